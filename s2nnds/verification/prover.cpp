// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/prover.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "s2nnds/core/check.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/verification/band_bound.h"
#include "s2nnds/verification/goal_neighbourhood.h"
#include "s2nnds/verification/guarantee.h"
#include "s2nnds/verification/network_function.h"
#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/standard_floating_point.h"
#include "s2nnds/verification/tile_examiner.h"

namespace s2nnds {
namespace {

// Half the side of the first cube around the goal that interval Jacobians are tried on, before its halves.
constexpr double largest_goal_cube = 0.08;

// Where no neighbourhood of the goal is proved, boxes this close to it are left open.
constexpr double hopeless_radius = 1e-8;

// From so many dimensions on, what a proof that found violations left open besides is most of the workspace: points of it are
// worth nothing. In the plane points of all that is open go back into training.
constexpr Eigen::Index kWideDimensions = 3;

// In more dimensions than this, no proof is gone on with that seems to need more boxes than are allowed.
constexpr Eigen::Index kPatientDimensions = 4;

// What a condition gets once the time for the whole proof is used up.
constexpr double least_seconds = 1e-9;

struct Statement {
  Condition condition;
  const ProofFunctions& functions;
  const SafetyProblem& problem;
  double level_band;
  double goal_cube;          // proved already for 0 < |x|_inf <= goal_cube
  double disturbance = 0.0;  // of f, which Bdot < 0 must withstand
};

Box box_of(const Points& lower, const Points& upper, Eigen::Index row) {
  return {lower.row(row).transpose(), upper.row(row).transpose()};
}

bool lies_on_face(const Box& box, const Box& workspace) {
  const auto fixed = box.lower.array() == box.upper.array();
  return (fixed &&
          (box.lower.array() == workspace.lower.array() || box.upper.array() == workspace.upper.array()))
      .any();
}

class ConditionExaminer final : public BoxExaminer {
 public:
  explicit ConditionExaminer(const Statement& statement)
      : statement_(statement),
        negated_(statement.condition == Condition::lyapunov_positive ||
                 statement.condition == Condition::unsafe || statement.condition == Condition::containment),
        along_field_(statement.condition == Condition::lyapunov_decrease ||
                     statement.condition == Condition::barrier_decrease),
        enclosure_(is_lyapunov() ? *statement.functions.V : *statement.functions.B,
                   along_field_ ? statement.functions.f.get() : nullptr),
        tile_(statement.problem.dimension()),
        barrier_(statement.problem.dimension()) {}

  void examine(BoxBatch& batch) override {
    std::vector<Eigen::Index> rows = where_it_applies(batch);
    if (is_in_band()) rows = ready_rows(batch, within_band(batch, rows));
    std::vector<Candidate> candidates;
    for_tiles(batch, rows, [&](const std::vector<Eigen::Index>& tile_rows) {
      const TileForm form = evaluate();
      const TileRow worst = upper_residual(form), best = lower_residual(form);
      std::optional<TileRow> where_asked;
      work_.setZero();
      const auto holds_in = [&](Eigen::Index lane) {
        if (statement_.disturbance == 0.0 && holds(worst(lane))) return true;
        if (!is_in_band() && set() == nullptr) return false;
        if (!where_asked) where_asked = upper_where_asked(form, tile_rows, batch.first);
        return holds((*where_asked)(lane));
      };
      for (std::size_t lane = 0; lane < tile_rows.size(); ++lane) {
        const Eigen::Index row = tile_rows[lane];
        const auto at = static_cast<Eigen::Index>(lane);
        if (holds_in(at)) {
          batch.status[row] = BoxStatus::proved;
        } else {
          cut(batch, row, useful_cuts(tile_.dimension(), best(at) + form.remainder(at), form.remainder(at)));
          consider(batch, row, form, at, candidates);
        }
      }
    });
    refute(batch, candidates);
  }

 private:
  struct Candidate {
    Eigen::Index row;
    Vector point;
  };

  bool is_lyapunov() const {
    return statement_.condition == Condition::lyapunov_positive ||
           statement_.condition == Condition::lyapunov_decrease;
  }
  // For the largest residual of a box. NaN does not hold.
  bool holds(double residual) const {
    return allows_zero(statement_.condition) ? residual <= 0.0 : residual < 0.0;
  }

  const TileForm& evaluate() {
    return along_field_ ? enclosure_.lie_derivative(tile_) : enclosure_.value(tile_);
  }
  TileRow upper_residual(const TileForm& form) const {
    return negated_ ? TileRow(-form.lower(tile_)) : form.upper(tile_);
  }
  TileRow lower_residual(const TileForm& form) const {
    return negated_ ? TileRow(-form.upper(tile_)) : form.lower(tile_);
  }

  Location location(const Box& box) const {
    const SafetyProblem& problem = statement_.problem;
    switch (statement_.condition) {
      case Condition::lyapunov_positive:
      case Condition::lyapunov_decrease: {
        const double reach = std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
        if (reach <= statement_.goal_cube) return Location::outside;
        return box.contains(Vector::Zero(box.dimension())) ? Location::unknown : Location::inside;
      }
      case Condition::initial:
        return problem.initial->classify(box);
      case Condition::unsafe:
        return problem.unsafe->classify(box);
      case Condition::containment:
        if (lies_on_face(box, problem.workspace)) return Location::inside;
        return problem.workspace_margin ? problem.workspace_margin->classify(box) : Location::outside;
      case Condition::barrier_decrease:
        return Location::inside;
    }
    return Location::unknown;
  }

  bool is_in_band() const { return statement_.condition == Condition::barrier_decrease; }
  // What B is to be positive or negative on, where a half-space may hold it; else null.
  const Region* set() const {
    if (statement_.condition == Condition::initial) return statement_.problem.initial.get();
    return statement_.condition == Condition::unsafe ? statement_.problem.unsafe.get() : nullptr;
  }
  bool asks_of_a_part() const { return set() != nullptr || statement_.condition == Condition::containment; }

  // A box that holds all points of this one at which the condition asks for something: from each end of each side, as much
  // as surely lies outside of the set is cut off, to a 64th of the side.
  Box asked_part(Box box) const {
    if (!asks_of_a_part() || location(box) != Location::unknown) return box;
    for (Eigen::Index d = 0; d < box.dimension(); ++d) {
      const double width = box.upper[d] - box.lower[d];
      for (Vector Box::*end : {&Box::lower, &Box::upper}) {
        const double inwards = end == &Box::lower ? width : -width;
        for (double share = 0.5; share > 0.01; share *= 0.5) {
          Box cut = box;
          const double at = (box.*end)[d] + share * inwards;
          if (!(at > box.lower[d] && at < box.upper[d])) continue;
          (end == &Box::lower ? cut.upper : cut.lower)[d] = at;
          if (location(cut) == Location::outside) (box.*end)[d] = at;
        }
      }
    }
    return box;
  }

  // The rows that are still to be decided; the others hold.
  std::vector<Eigen::Index> where_it_applies(BoxBatch& batch) const {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index row = batch.first; row < batch.first + batch.count; ++row) {
      const Box box = box_of(batch.lower, batch.upper, row);
      if (location(box) == Location::outside) {
        batch.status[row] = BoxStatus::excluded;
      } else if (is_lyapunov() && box.lower.cwiseAbs().maxCoeff() <= hopeless_radius &&
                 box.upper.cwiseAbs().maxCoeff() <= hopeless_radius) {
        batch.status[row] = BoxStatus::abandoned;
      } else {
        rows.push_back(row);
      }
    }
    return rows;
  }

  // The rows that the band may meet. Remembers B on them, for barrier_of.
  std::vector<Eigen::Index> within_band(BoxBatch& batch, const std::vector<Eigen::Index>& rows) {
    std::vector<Eigen::Index> kept;
    barriers_.clear();
    places_.assign(static_cast<std::size_t>(batch.count), {});
    for_tiles(batch, rows, [&](const std::vector<Eigen::Index>& tile_rows) {
      const TileForm& barrier = enclosure_.value(tile_);
      const TileRow low = barrier.lower(tile_), high = barrier.upper(tile_);
      for (std::size_t lane = 0; lane < tile_rows.size(); ++lane) {
        const auto at = static_cast<Eigen::Index>(lane);
        if (low(at) > statement_.level_band || high(at) < -statement_.level_band) {
          batch.status[tile_rows[lane]] = BoxStatus::excluded;
        } else {
          kept.push_back(tile_rows[lane]);
          places_[static_cast<std::size_t>(tile_rows[lane] - batch.first)] = {barriers_.size(), at};
        }
      }
      barriers_.push_back(barrier);
    });
    return kept;
  }
  // Of the many parts that a bound of Bdot may need, the band meets few: so a box is halved once along each axis, and until
  // all cuts are done only B is looked at on the parts. How large they are then is carried on.
  void cut(BoxBatch& batch, Eigen::Index row, std::int32_t cuts) const {
    const auto n = static_cast<std::int32_t>(tile_.dimension());
    batch.cuts[row] = cuts;
    if (!is_in_band() || n > kPatientDimensions || cuts <= n) return;
    batch.cuts[row] = n;
    batch.carried(row) = volume(batch, row) * std::exp2(-std::min(cuts, most_cuts));
  }
  // The rows whose cuts are all done; the others go on with them.
  std::vector<Eigen::Index> ready_rows(BoxBatch& batch, const std::vector<Eigen::Index>& rows) const {
    std::vector<Eigen::Index> ready;
    for (const Eigen::Index row : rows) {
      const double wanted = std::exchange(batch.carried(row), std::numeric_limits<double>::infinity());
      const double parts = volume(batch, row) / wanted;  // 0 where nothing was carried
      if (!(parts >= 1.5)) {
        ready.push_back(row);
      } else {
        cut(batch, row, static_cast<std::int32_t>(std::lround(std::log2(parts))));
      }
    }
    return ready;
  }
  static double volume(const BoxBatch& batch, Eigen::Index row) {
    return (batch.upper.row(row) - batch.lower.row(row)).prod();
  }
  // Above the residual where the condition asks for something.
  TileRow upper_where_asked(const TileForm& form, const std::vector<Eigen::Index>& tile_rows,
                            Eigen::Index first) {
    if (is_in_band()) {
      barrier_ = barrier_of(tile_rows, first);
      const TileRow upper = upper_within(form, barrier_, statement_.level_band, tile_);
      TileRow slope;  // at the centres, about
      for (const TileRow& row : barrier_.gradient) slope += row.square();
      work_ = statement_.disturbance * slope.sqrt();
      if (!(upper + work_ < 0.0).any())  // no bound is needed
        return TileRow(TileRow::Constant(std::numeric_limits<double>::infinity()));
      work_ = most_work();
      return upper + work_;
    }
    return upper_below(negated_ ? form.negative() : form, halfspaces(), tile_);
  }
  // Above and below what the worst disturbance adds to Bdot, at each place of the boxes in tile_.
  TileRow most_work() {
    if (statement_.disturbance == 0.0) return {};
    return statement_.disturbance * gradient_norm(enclosure_, tile_) * slack;
  }
  TileRow least_work() {
    if (statement_.disturbance == 0.0) return {};
    return statement_.disturbance * least_gradient_norm(enclosure_, tile_) / slack;
  }
  // normal . x - offset <= 0 for the points of the set in each box; 0 where no half-space is known.
  TileForm halfspaces() const {
    TileForm level(tile_.dimension());
    for (Eigen::Index lane = 0; lane < tile_boxes; ++lane) {
      const Box& box = asked_[std::min(static_cast<std::size_t>(lane), asked_.size() - 1)];
      const auto bound = set()->bounding_halfspace(box, 0.0);
      if (!bound) continue;
      level.value(lane) = -bound->offset;
      level.magnitude(lane) = std::abs(bound->offset);
      for (Eigen::Index d = 0; d < box.dimension(); ++d) {
        level.gradient[d](lane) = bound->normal[d];
        level.value(lane) += bound->normal[d] * tile_.center[d](lane);
        level.magnitude(lane) += std::abs(bound->normal[d] * tile_.center[d](lane));
      }
    }
    return level;
  }
  TileForm barrier_of(const std::vector<Eigen::Index>& tile_rows, Eigen::Index first) const {
    TileForm barrier(tile_.dimension());
    for (Eigen::Index lane = 0; lane < tile_boxes; ++lane) {
      const auto filled = std::min(static_cast<std::size_t>(lane), tile_rows.size() - 1);
      const Place& place = places_[static_cast<std::size_t>(tile_rows[filled] - first)];
      barrier.take(barriers_[place.tile], place.lane, lane);
    }
    return barrier;
  }

  // Puts the rows into tiles and calls back for each one.
  template <typename Visit>
  void for_tiles(const BoxBatch& batch, const std::vector<Eigen::Index>& rows, const Visit& visit) {
    for (std::size_t first = 0; first < rows.size(); first += tile_boxes) {
      const std::size_t last = std::min(rows.size(), first + static_cast<std::size_t>(tile_boxes));
      const std::vector<Eigen::Index> tile_rows(rows.begin() + first, rows.begin() + last);
      asked_.clear();
      Points lower(tile_rows.size(), tile_.dimension()), upper = lower;
      for (std::size_t lane = 0; lane < tile_rows.size(); ++lane) {
        const Box box = asked_part(box_of(batch.lower, batch.upper, tile_rows[lane]));
        lower.row(lane) = box.lower.transpose();
        upper.row(lane) = box.upper.transpose();
        asked_.push_back(box);
      }
      tile_.assign(lower, upper, 0, lower.rows());
      visit(tile_rows);
    }
  }

  // Remembers a point of the box that probably violates the condition.
  void consider(const BoxBatch& batch, Eigen::Index row, const TileForm& form, Eigen::Index lane,
                std::vector<Candidate>& candidates) const {
    const double sign = negated_ ? -1.0 : 1.0;
    Vector point(tile_.dimension());
    for (Eigen::Index d = 0; d < point.size(); ++d) point(d) = tile_.center[d](lane);
    if (!(sign * form.value(lane) + work_(lane) > 0.0)) {
      point = form.extreme_point(tile_, lane, sign);
      if (!(sign * form.polynomial(tile_, lane, point) > form.remainder(lane))) return;
    }
    point = point.cwiseMax(batch.lower.row(row).transpose()).cwiseMin(batch.upper.row(row).transpose());
    if (is_asked_at(point, lane)) candidates.push_back({row, std::move(point)});
  }
  // Whether the condition asks for something at this point of the lane's box; of the band, probably.
  bool is_asked_at(const Vector& point, Eigen::Index lane) const {
    if (location({point, point}) != Location::inside) return false;
    return !is_in_band() || std::abs(barrier_.polynomial(tile_, lane, point)) - barrier_.remainder(lane) <=
                                statement_.level_band;
  }

  // Evaluates the candidates rigorously, as boxes without extent.
  void refute(BoxBatch& batch, const std::vector<Candidate>& candidates) {
    for (std::size_t first = 0; first < candidates.size(); first += tile_boxes) {
      const std::size_t count = std::min(candidates.size() - first, static_cast<std::size_t>(tile_boxes));
      Points points(count, tile_.dimension());
      for (std::size_t i = 0; i < count; ++i) points.row(i) = candidates[first + i].point.transpose();
      tile_.assign(points, points, 0, points.rows());
      TileRow size;
      if (is_in_band()) {
        const TileForm& barrier = enclosure_.value(tile_);
        size = barrier.upper(tile_).max(-barrier.lower(tile_));
      }
      const TileRow violation = lower_residual(evaluate()) + least_work();
      for (std::size_t i = 0; i < count; ++i) {
        const Candidate& candidate = candidates[first + i];
        const auto lane = static_cast<Eigen::Index>(i);
        const bool violated =
            allows_zero(statement_.condition) ? violation(lane) > 0.0 : violation(lane) >= 0.0;
        if (!violated || !(size(lane) <= statement_.level_band)) continue;
        batch.status[candidate.row] = BoxStatus::refuted;
        batch.witness.row(candidate.row) = candidate.point.transpose();
        batch.violation(candidate.row) = violation(lane);
      }
    }
  }

  struct Place {
    std::size_t tile;
    Eigen::Index lane;
  };

  Statement statement_;
  std::vector<Box> asked_;          // the boxes in tile_
  std::vector<TileForm> barriers_;  // of a batch, tile by tile
  std::vector<Place> places_;       // in them, of each row of the batch
  TileRow work_;                    // most_work of tile_ or about as much, where it was asked for; else 0
  bool negated_, along_field_;
  ScalarEnclosure enclosure_;
  BoxTile tile_;
  TileForm barrier_;  // B on tile_, where the band was looked at
};

// The workspace, and for containment its faces.
void starting_boxes(const Statement& statement, Points& lower, Points& upper) {
  const Box& workspace = statement.problem.workspace;
  const Eigen::Index n = workspace.dimension();
  const bool faces = statement.condition == Condition::containment;
  lower = workspace.lower.transpose().replicate(faces ? 1 + 2 * n : 1, 1);
  upper = workspace.upper.transpose().replicate(faces ? 1 + 2 * n : 1, 1);
  for (Eigen::Index d = 0; faces && d < n; ++d) {
    upper(1 + 2 * d, d) = workspace.lower(d);
    lower(2 + 2 * d, d) = workspace.upper(d);
  }
}

bool is_goal_safe(const ProofFunctions& functions) {
  BoxTile origin(functions.B->input_dimension());
  ScalarEnclosure barrier(*functions.B, nullptr);
  return barrier.value(origin).upper(origin)(0) <= 0.0;
}

// X0 has no point beyond any face of the workspace.
bool is_initial_in_workspace(const SafetyProblem& problem) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Eigen::Index n = problem.dimension();
  for (Eigen::Index d = 0; d < n; ++d) {
    Box above = {Vector::Constant(n, -infinity), Vector::Constant(n, infinity)}, below = above;
    above.lower(d) = next_up(problem.workspace.upper(d));
    below.upper(d) = next_down(problem.workspace.lower(d));
    if (problem.initial->classify(above) != Location::outside) return false;
    if (problem.initial->classify(below) != Location::outside) return false;
  }
  return true;
}

ConditionProof decide(const Statement& statement, const BranchLimits& limits, const ProofProgress& progress) {
  Points lower, upper;
  starting_boxes(statement, lower, upper);
  BranchResult found = branch_and_bound(
      std::move(lower), std::move(upper), [&] { return std::make_unique<ConditionExaminer>(statement); },
      limits,
      [&](const BranchProgress& state) {
        if (progress) progress(statement.condition, state);
      });
  ConditionProof proof;
  proof.open_lower = found.open_lower;
  proof.open_upper = found.open_upper;
  proof.witnesses = found.witnesses;
  proof.tree = std::move(found.tree);
  proof.verdict.verdict = found.proved                 ? Verdict::proved
                          : found.witnesses.rows() > 0 ? Verdict::refuted
                                                       : Verdict::undecided;
  proof.verdict.boxes = found.boxes;
  proof.verdict.open_boxes = found.open_boxes;
  proof.verdict.open_volume = found.open_volume;
  proof.verdict.worst = found.worst;
  if (found.expected > 0.0 && !found.proved && found.witnesses.rows() == 0) {
    proof.verdict.reason =
        fmt::format("some {:.0e} boxes seem to be needed, {} are allowed", found.expected, limits.max_boxes);
  }
  if (found.witnesses.rows() > 0) {
    proof.verdict.witness.assign(found.witnesses.data(), found.witnesses.data() + found.witnesses.cols());
  }
  return proof;
}

// The whole workspace is left open.
ConditionProof not_examined(const SafetyProblem& problem, const std::string& reason) {
  ConditionProof proof;
  proof.verdict.verdict = Verdict::undecided;
  proof.verdict.reason = reason;
  proof.verdict.open_boxes = 1;
  proof.open_lower = problem.workspace.lower.transpose();
  proof.open_upper = problem.workspace.upper.transpose();
  proof.verdict.open_volume = (proof.open_upper - proof.open_lower).prod();
  proof.witnesses = Points(0, problem.dimension());
  return proof;
}

ConditionProof holds_by_construction(const SafetyProblem& problem) {
  ConditionProof proof;
  proof.verdict.verdict = Verdict::proved;
  proof.open_lower = proof.open_upper = proof.witnesses = Points(0, problem.dimension());
  return proof;
}

// Of the Lyapunov conditions, by interval Jacobians.
double proved_cube(const ProofFunctions& functions, Condition condition) {
  if (condition == Condition::lyapunov_positive) return positive_cube(*functions.V, largest_goal_cube);
  if (condition != Condition::lyapunov_decrease) return 0.0;
  return decreasing_cube(*functions.f, *functions.V, largest_goal_cube);
}

void check_dimensions(const ProofFunctions& functions, const SafetyProblem& problem) {
  check(functions.f && functions.V && functions.B, "proof: expected f, V and B");
  check(problem.initial && problem.unsafe, "proof: expected an initial and an unsafe set");
  const Eigen::Index n = problem.dimension();
  check(problem.workspace.is_finite() && !problem.workspace.is_empty(),
        "proof: expected a bounded workspace");
  for (const TaylorFunction* function : {functions.f.get(), functions.V.get(), functions.B.get()}) {
    check(function->input_dimension() == n, "proof: found a function of {} variables, expected {}",
          function->input_dimension(), n);
  }
  check(functions.f->output_dimension() == n, "proof: f has {} outputs, expected {}",
        functions.f->output_dimension(), n);
}

}  // namespace

ProofOptions ProofOptions::fail_fast() {
  ProofOptions options;
  options.max_boxes = 60000;
  options.max_refuted = 200;
  options.max_after_refuted = 10000;
  options.kept_boxes = 2000;
  return options;
}

void ProofOptions::visit(FieldVisitor& v) {
  v.field("max_boxes", max_boxes, at_least(1));
  v.field("max_seconds", max_seconds, above(0.0));
}

ProofFunctions ProofFunctions::of(const Networks& networks) {
  check(
      !networks.is_projected() && networks.V.head != Head::diffeomorphism,
      "proof: found a projected f or a V that is a diffeomorphism, which the prover does not know; expected "
      "--method conformal or sampled");
  return {std::make_shared<NetworkFunction>(networks.f), std::make_shared<NetworkFunction>(networks.V),
          std::make_shared<NetworkFunction>(networks.B)};
}

std::string ProofFunctions::beyond_range(const Box& workspace) const {
  const double reach = std::max(workspace.lower.cwiseAbs().maxCoeff(), workspace.upper.cwiseAbs().maxCoeff());
  for (const auto& [name, function] : {std::pair{"f", &f}, std::pair{"V", &V}, std::pair{"B", &B}}) {
    const double growth = (*function)->growth(reach);
    if (!(growth <= largest_growth)) {
      return fmt::format("{} can magnify numbers by {:.1e}, beyond the {:.0e} for which underflow is covered",
                         name, growth, largest_growth);
    }
  }
  return "";
}

Points points_in_boxes(const Points& lower, const Points& upper, std::size_t count, RandomStream& random) {
  Points points(lower.rows() > 0 ? count : 0, lower.cols());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto box = static_cast<Eigen::Index>(random.below(static_cast<std::size_t>(lower.rows())));
    for (Eigen::Index d = 0; d < points.cols(); ++d)
      points(i, d) = random.uniform(lower(box, d), upper(box, d));
  }
  return points;
}

Points ConditionProof::samples(std::size_t count, RandomStream& random) const {
  if (open_lower.rows() == 0) return Points(0, open_lower.cols());
  const Eigen::Index certain = std::min(witnesses.rows(), static_cast<Eigen::Index>(count));
  Points points(count, open_lower.cols());
  points.topRows(certain) = witnesses.topRows(certain);
  // The boxes of the witnesses come first.
  const bool only_refuted = witnesses.rows() > 0 && points.cols() >= kWideDimensions;
  const Eigen::Index boxes = only_refuted ? witnesses.rows() : open_lower.rows();
  points.bottomRows(points.rows() - certain) =
      points_in_boxes(open_lower.topRows(boxes), open_upper.topRows(boxes),
                      static_cast<std::size_t>(points.rows() - certain), random);
  return points;
}

std::vector<ConditionVerdict> ProofResult::verdicts() const {
  std::vector<ConditionVerdict> all;
  for (const ConditionProof& proof : conditions) all.push_back(proof.verdict);
  return all;
}

const ConditionProof& ProofResult::operator[](Condition condition) const {
  const auto found = std::find_if(conditions.begin(), conditions.end(), [&](const ConditionProof& proof) {
    return proof.verdict.condition == condition;
  });
  check(found != conditions.end(), "proof: found no verdict on {}", to_string(condition));
  return *found;
}

namespace {

ConditionProof prove_one(Condition condition, const ProofFunctions& functions, const SafetyProblem& problem,
                         double level_band, double disturbance, const ProofOptions& options,
                         const ProofProgress& progress) {
  validate(options);
  check_dimensions(functions, problem);
  check(level_band >= 0.0, "proof: level_band is {}, expected >= 0", level_band);
  check(disturbance >= 0.0, "proof: the disturbance is {}, expected >= 0", disturbance);
  const Stopwatch watch;
  const StandardFloatingPoint mode;
  ConditionProof proof;
  if (const std::string reason = functions.beyond_range(problem.workspace); !reason.empty()) {
    proof = not_examined(problem, reason);
  } else if (condition == Condition::lyapunov_positive && functions.V->is_positive_by_construction()) {
    proof = holds_by_construction(problem);
  } else {
    const double cube = proved_cube(functions, condition);
    BranchLimits limits = options;
    limits.max_seconds = options.max_seconds - watch.seconds();
    if (problem.dimension() > kPatientDimensions)
      limits.max_expected = static_cast<double>(options.max_boxes);
    proof = decide({condition, functions, problem, level_band, cube, disturbance}, limits, progress);
    proof.goal_cube = cube;
  }
  proof.verdict.condition = condition;
  proof.verdict.method = Method::proof;
  proof.verdict.seconds = watch.seconds();
  return proof;
}

}  // namespace

ConditionProof prove_condition(Condition condition, const ProofFunctions& functions,
                               const SafetyProblem& problem, double level_band, const ProofOptions& options,
                               const ProofProgress& progress) {
  return prove_one(condition, functions, problem, level_band, 0.0, options, progress);
}

ConditionProof prove_barrier_decrease(const ProofFunctions& functions, const SafetyProblem& problem,
                                      double level_band, double disturbance, const ProofOptions& options) {
  return prove_one(Condition::barrier_decrease, functions, problem, level_band, disturbance, options,
                   nullptr);
}

ProofResult prove(const ProofFunctions& functions, const SafetyProblem& problem, double level_band,
                  const ProofOptions& options, const ProofProgress& progress) {
  const Stopwatch watch;
  const StandardFloatingPoint mode;
  ProofResult result;
  ProofOptions left = options;
  for (Condition condition : all_conditions) {
    ConditionProof proof = prove_condition(condition, functions, problem, level_band, left, progress);
    left.max_seconds = std::max(options.max_seconds - watch.seconds(), least_seconds);
    if (condition == Condition::lyapunov_decrease) result.goal_cube = proof.goal_cube;
    result.boxes += proof.verdict.boxes;
    result.conditions.push_back(std::move(proof));
  }
  result.side = {.goal_is_equilibrium = functions.f->vanishes_at_goal(),
                 .lyapunov_vanishes_at_goal = functions.V->vanishes_at_goal(),
                 .goal_is_safe = functions.beyond_range(problem.workspace).empty() && is_goal_safe(functions),
                 .initial_in_workspace = is_initial_in_workspace(problem)};
  result.guarantee = guarantee_of(result.verdicts(), result.side, problem);
  result.seconds = watch.seconds();
  return result;
}

ProofResult prove(const Networks& networks, const SafetyProblem& problem, double level_band,
                  const ProofOptions& options, const ProofProgress& progress) {
  return prove(ProofFunctions::of(networks), problem, level_band, options, progress);
}

}  // namespace s2nnds
