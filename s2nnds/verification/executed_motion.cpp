// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/executed_motion.h"

#include <atomic>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/verification/convergence_ball.h"
#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/standard_floating_point.h"
#include "s2nnds/verification/tile_examiner.h"

namespace s2nnds {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Boxes this small, relative to the workspace, are given up.
constexpr double level_resolution = 1e-4;
constexpr std::int64_t most_boxes = 500000;
constexpr double most_seconds = 60.0;
// Cells of the cover on which bounds for the whole safe set are taken.
constexpr double cover_cells = 4096.0;

// |value - middle| <= radius, for each of some numbers.
struct TileIntervals {
  explicit TileIntervals(Eigen::Index count) : middle(count), radius(count) {}

  TileRow size(Eigen::Index i) const { return (middle[i].abs() + radius[i]) * slack; }
  TileRow norm() const {  // above the 2-norm
    TileRow sum;
    for (Eigen::Index i = 0; i < std::ssize(middle); ++i) sum += size(i).square();
    return sum.sqrt() * slack + underflow;
  }

  std::vector<TileRow> middle, radius;
};

// sum_k a_k b_k over the given entries, with its rounding.
class ProductSum {
 public:
  void add(const TileRow& a, const TileRow& a_radius, const TileRow& b, const TileRow& b_radius) {
    const TileRow product = a * b;
    middle += product;
    radius += a.abs() * b_radius + a_radius * (b.abs() + b_radius) + 1e-13 * product.abs() + underflow;
  }
  void store(TileIntervals& to, Eigen::Index i) const {
    to.middle[i] = middle;
    to.radius[i] = radius * slack;
  }
  TileRow size() const { return (middle.abs() + radius) * slack; }

 private:
  TileRow middle, radius;
};

// Each box of the tile with all that is within `distance` of it.
BoxTile grown(const BoxTile& tile, double distance) {
  BoxTile larger = tile;
  for (TileRow& half : larger.half) half = (half + distance) * slack;
  return larger;
}

// f and its Jacobian on tiles; for one thread.
class FieldEnclosure {
 public:
  explicit FieldEnclosure(const TaylorFunction& field)
      : field_(field),
        workspace_(field.workspace()),
        models_(field.output_dimension(), field.input_dimension()),
        value(field.output_dimension()),
        jacobian(field.output_dimension() * field.input_dimension()) {}

  void evaluate_value(const BoxTile& tile) {
    field_.models(tile, *workspace_, models_);
    store(tile, value, 0, 1);
  }
  void evaluate_jacobian(const BoxTile& tile) {
    for (Eigen::Index axis = 0; axis < tile.dimension(); ++axis) {
      field_.partial_models(tile, *workspace_, axis, models_);
      store(tile, jacobian, axis, tile.dimension());
    }
  }

 private:
  void store(const BoxTile& tile, TileIntervals& to, Eigen::Index first, Eigen::Index stride) const {
    for (Eigen::Index i = 0; i < field_.output_dimension(); ++i) {
      to.middle[first + i * stride] = models_.value(i);
      to.radius[first + i * stride] =
          (models_.spread(i, tile) + models_.deviation(i, tile)) * slack + underflow;
    }
  }

  const TaylorFunction& field_;
  std::unique_ptr<TaylorFunction::Workspace> workspace_;
  TileModels models_;

 public:
  TileIntervals value,  // [n]
      jacobian;         // [n, n]
};

TileIntervals gradient_of(ScalarEnclosure& function, const BoxTile& tile) {
  TileIntervals gradient(tile.dimension());
  for (Eigen::Index d = 0; d < tile.dimension(); ++d) {
    const TileForm& partial = function.partial_derivative(tile, d);
    const TileRow low = partial.lower(tile), high = partial.upper(tile);
    gradient.middle[d] = 0.5 * low + 0.5 * high;
    gradient.radius[d] = (0.5 * (high - low) + 1e-15 * (low.abs() + high.abs())) * slack + underflow;
  }
  return gradient;
}

// What follows from the model for the whole of {B <= 0}.
struct ExecutionBounds {
  ExecutionModel model;
  double field = 0.0;         // above |f| + field_error at every reading
  double most_command = 0.0;  // above |speed f| there
  double most_rate = 0.0;     // above |xdot|
  // From the present place, above the distance of every reading that had a part in the motion since the
  // oldest reading that still counts.
  double reach = 0.0;
  double lag_error = 0.0;  // above |v - speed f(x)| / speed, where lag > 0

  // (|w| + |error of the command|) / speed where |u| / speed is at most `size`.
  double noise(double size) const {
    return (model.velocity_error / model.least_speed + model.velocity_error_relative * size +
            model.field_error) *
           slack;
  }
};

// Calls visit(tile) for cells that cover the part of the workspace where B <= 0 may hold.
template <typename Visit>
void for_cells(const ProofFunctions& functions, const Box& box, const Visit& visit) {
  const Eigen::Index n = box.dimension();
  const auto side = static_cast<Eigen::Index>(
      std::max(2.0, std::floor(std::pow(cover_cells, 1.0 / static_cast<double>(n)))));
  Eigen::Index cells = 1;
  for (Eigen::Index d = 0; d < n; ++d) cells *= side;
  const auto edge = [&](Eigen::Index d, Eigen::Index k) {  // neighbours share it
    if (k == side) return box.upper(d);
    return box.lower(d) +
           (box.upper(d) - box.lower(d)) * (static_cast<double>(k) / static_cast<double>(side));
  };
  BoxTile tile(n);
  ScalarEnclosure barrier(*functions.B, nullptr);
  for (Eigen::Index first = 0; first < cells; first += tile_boxes) {
    const Eigen::Index count = std::min<Eigen::Index>(tile_boxes, cells - first);
    Points lower(count, n), upper(count, n);
    for (Eigen::Index i = 0; i < count; ++i) {
      for (Eigen::Index d = 0, rest = first + i; d < n; ++d, rest /= side) {
        lower(i, d) = edge(d, rest % side);
        upper(i, d) = edge(d, rest % side + 1);
      }
    }
    tile.assign(lower, upper, 0, count);
    const TileRow low = barrier.value(tile).lower(tile);
    if ((low > 0.0).all()) continue;
    visit(tile, low);
  }
}

// The largest of `values` where B may be <= 0; NaN counts as infinite.
double largest(const TileRow& values, const TileRow& barrier_low) {
  double found = 0.0;
  for (Eigen::Index lane = 0; lane < tile_boxes; ++lane) {
    if (barrier_low(lane) > 0.0) continue;
    found = std::max(found, std::isnan(values(lane)) ? infinity : values(lane));
  }
  return found;
}

ExecutionBounds bounds_of(const ProofFunctions& functions, const SafetyProblem& problem,
                          const ExecutionModel& model) {
  ExecutionBounds bounds{.model = model};
  FieldEnclosure field(*functions.f);
  for_cells(functions, problem.workspace, [&](const BoxTile& tile, const TileRow& low) {
    field.evaluate_value(grown(tile, model.position_error));
    bounds.field = std::max(bounds.field, largest(field.value.norm(), low));
  });
  bounds.field = (bounds.field + model.field_error) * slack;
  bounds.most_command = model.most_speed * bounds.field * slack;
  bounds.most_rate =
      (bounds.most_command * (1.0 + model.velocity_error_relative) + model.velocity_error) * slack;
  bounds.reach = (model.position_error + 2.0 * model.window() * bounds.most_rate) * slack;
  if (!(model.lag > 0.0)) return bounds;
  // lag edot = (u - speed f(x)) - e - lag speed J_f(x) xdot for e = v - speed f(x).
  double steepest = 0.0;
  for_cells(functions, problem.workspace, [&](const BoxTile& tile, const TileRow& low) {
    field.evaluate_jacobian(grown(tile, bounds.reach));
    steepest = std::max(steepest, largest(field.jacobian.norm(), low));
  });
  bounds.lag_error = (steepest * (model.position_error + (model.window() + model.lag) * bounds.most_rate) +
                      model.field_error) *
                     slack;
  return bounds;
}

// delta = xdot / speed - f(x) of the model, at places in {B <= 0}.
class ExecutionPerturbation final : public Perturbation {
 public:
  // `arbitrary`: any velocity up to most_command may have been commanded before, not only speed f.
  ExecutionPerturbation(const ProofFunctions& functions, const ExecutionBounds& bounds, bool arbitrary)
      : bounds_(bounds), arbitrary_(arbitrary), field_(*functions.f) {}

  TileRow work(ScalarEnclosure& function, const BoxTile& tile) override {
    const ExecutionModel& model = bounds_.model;
    const TileIntervals gradient = gradient_of(function, tile);
    const TileRow norm = gradient.norm();
    if (model.lag > 0.0) {
      return norm * ((bounds_.lag_error + bounds_.noise(bounds_.field)) * slack) * slack;
    }
    const BoxTile around = grown(tile, bounds_.reach);
    field_.evaluate_value(around);
    field_.evaluate_jacobian(around);
    const TileIntervals pulled = pull_back(gradient);
    const TileRow pulled_norm = pulled.norm(), speed = field_.value.norm();
    if (arbitrary_) {
      const double distance = (model.position_error + model.window() * bounds_.most_rate) * slack;
      return (pulled_norm * distance + norm * bounds_.noise(bounds_.field)) * slack;
    }
    // |w| / speed and |w| on the way, and p . f: f(y) - f(x) = J (error of the reading - what was moved
    // since).
    const TileRow command = speed + model.field_error;  // |u| / speed
    const TileRow noise = model.velocity_error / model.least_speed + model.velocity_error_relative * command +
                          model.field_error;
    const TileRow rate_noise =
        model.velocity_error +
        model.most_speed * (model.velocity_error_relative * command + model.field_error);
    ProductSum along;
    for (Eigen::Index j = 0; j < tile.dimension(); ++j)
      along.add(pulled.middle[j], pulled.radius[j], field_.value.middle[j], field_.value.radius[j]);
    const TileRow moved = model.most_speed * along.size() + pulled_norm * rate_noise;
    return (pulled_norm * model.position_error + model.window() * moved * slack + norm * noise) * slack *
               slack +
           underflow;
  }

 private:
  // grad' J.
  TileIntervals pull_back(const TileIntervals& gradient) const {
    const auto n = static_cast<Eigen::Index>(gradient.middle.size());
    TileIntervals pulled(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      ProductSum sum;
      for (Eigen::Index i = 0; i < n; ++i) {
        sum.add(gradient.middle[i], gradient.radius[i], field_.jacobian.middle[i * n + j],
                field_.jacobian.radius[i * n + j]);
      }
      sum.store(pulled, j);
    }
    return pulled;
  }

  const ExecutionBounds& bounds_;
  bool arbitrary_;
  FieldEnclosure field_;
};

// What a shield has to know of B around {B = 0}.
struct LevelSetVariation {
  double distance = 0.0;  // of a reading from the place, at most
  std::atomic<double> value = 0.0, gradient = 0.0;
};

// grad B . (f + delta) < 0 wherever B = 0.
class LevelSetExaminer final : public TileExaminer {
 public:
  LevelSetExaminer(const ProofFunctions& functions, double resolution,
                   std::unique_ptr<Perturbation> perturbation, LevelSetVariation* variation)
      : TileExaminer(functions, resolution),
        perturbation_(std::move(perturbation)),
        variation_(variation),
        hopeless_width_(hopeless_boxes * resolution) {}

 private:
  // Where the rate hardly varies over a small box and fails by more than that, its parts will fail too,
  // unless {B = 0} misses them. Giving up too early costs a certificate, never its truth.
  static constexpr double small = 0.03, hopeless_boxes = 40.0;

  void evaluate() override {
    const TileForm& value = barrier_.value(tile_);
    meets_ = !((value.lower(tile_) > 0.0) || (value.upper(tile_) < 0.0));
    if (!meets_.any()) return;
    const TileForm& form = barrier_.lie_derivative(tile_);
    const TileRow rate = form.upper(tile_);
    spread_ = rate - form.value;
    rate_ = rate;
    hopeless_.setConstant(false);
    if (!(meets_ && rate < 0.0).any()) return;
    const TileRow work = perturbation_->work(barrier_, tile_) * slack;
    hopeless_ = spread_ < small * rate.abs() && rate - spread_ + (1.0 - small) * work > 0.0;
    rate_ += work;
    if (variation_ != nullptr && (meets_ && rate_ < -1e-300).any()) find_variation();
  }
  void find_variation() {
    const BoxTile around = grown(tile_, variation_->distance);
    value_change_ = barrier_.value(around).variation(around, variation_->distance);
    TileRow sum;
    for (Eigen::Index d = 0; d < tile_.dimension(); ++d) {
      sum += barrier_.partial_derivative(around, d).variation(around, variation_->distance).square();
    }
    gradient_change_ = sum.sqrt() * slack;
  }
  BoxStatus judge(Eigen::Index lane, const Eigen::RowVectorXd& lower, const Eigen::RowVectorXd& upper,
                  bool narrow) override {
    if (!meets_(lane)) return BoxStatus::proved;
    if (!(rate_(lane) < -1e-300)) {
      const bool small_enough = (upper - lower).maxCoeff() <= hopeless_width_;
      return narrow || (small_enough && hopeless_(lane)) ? BoxStatus::abandoned : BoxStatus::undecided;
    }
    if (variation_ != nullptr) {
      // On wide boxes the variation would be that of the box.
      const double wide = std::max(2.0 * variation_->distance, hopeless_width_);
      if (!((upper - lower).maxCoeff() <= wide)) return BoxStatus::undecided;
      raise_to(variation_->value, value_change_(lane));
      raise_to(variation_->gradient, gradient_change_(lane));
    }
    return BoxStatus::proved;
  }

  std::unique_ptr<Perturbation> perturbation_;
  LevelSetVariation* variation_;
  TileRow rate_, spread_, value_change_, gradient_change_;
  Eigen::Array<bool, tile_boxes, 1> meets_, hopeless_;
  double hopeless_width_;
};

void check_model(const ExecutionModel& model) {
  const auto is_size = [](double x) { return x >= 0.0 && x < infinity; };
  check(is_size(model.period) && is_size(model.delay) && is_size(model.lag) &&
            is_size(model.position_error) && is_size(model.velocity_error) &&
            is_size(model.velocity_error_relative),
        "execution: found a time or an error that is negative or not finite, expected finite ones >= 0");
  check(model.least_speed > 0.0 && model.least_speed <= model.most_speed && model.most_speed < infinity,
        "execution: found the speed factors {} to {}, expected 0 < least <= most", model.least_speed,
        model.most_speed);
}

// Why the bounds do not hold; "" if they do.
std::string beyond_range(const ProofFunctions& functions, const Box& workspace,
                         const ExecutionBounds& bounds) {
  const double size = std::max(workspace.lower.cwiseAbs().maxCoeff(), workspace.upper.cwiseAbs().maxCoeff());
  if (!(bounds.reach <= 10.0 * size) || !(bounds.lag_error < infinity)) {
    return fmt::format(
        "readings may be {:.3g} normalised units away from where the robot is, farther than the workspace is "
        "wide",
        bounds.reach);
  }
  for (const auto& function : {functions.f, functions.V, functions.B}) {
    if (!(function->growth(size + bounds.reach) <= largest_growth))
      return "weights are beyond those for which underflow is covered";
  }
  return "";
}

// Boxes that fail come back; one that does is enough to end.
BranchLimits level_set_limits(std::int64_t kept_boxes = 0) {
  BranchLimits limits;
  limits.max_boxes = most_boxes;
  limits.max_abandoned = std::max<std::int64_t>(kept_boxes, 1);
  limits.kept_boxes = kept_boxes;
  limits.max_seconds = most_seconds;
  return limits;
}

BranchResult examine_level_set(const ProofFunctions& functions, const SafetyProblem& problem,
                               const PerturbationFactory& perturbation, LevelSetVariation* variation,
                               std::int64_t kept_boxes = 0) {
  const Box& workspace = problem.workspace;
  const double resolution = level_resolution * (workspace.upper - workspace.lower).maxCoeff();
  return branch_and_bound(
      workspace.lower.transpose(), workspace.upper.transpose(),
      [&] { return std::make_unique<LevelSetExaminer>(functions, resolution, perturbation(), variation); },
      level_set_limits(kept_boxes));
}

PerturbationFactory perturbations(const ProofFunctions& functions, const ExecutionBounds& bounds,
                                  bool arbitrary) {
  return [&functions, &bounds, arbitrary] {
    return std::make_unique<ExecutionPerturbation>(functions, bounds, arbitrary);
  };
}

// Whether all speed factors from `least` to `most` are certified; most_command is raised to that of `most`.
bool certifies(const ProofFunctions& functions, const SafetyProblem& problem, ExecutionModel model,
               double least, double most, double& most_command) {
  model.least_speed = least;
  model.most_speed = most;
  const ExecutionBounds bounds = bounds_of(functions, problem, model);
  if (!beyond_range(functions, problem.workspace, bounds).empty()) return false;
  if (!examine_level_set(functions, problem, perturbations(functions, bounds, false), nullptr).proved)
    return false;
  most_command = std::max(most_command, bounds.most_command);
  return true;
}

}  // namespace

ExecutedMotion prove_executed(const ProofFunctions& functions, const SafetyProblem& problem,
                              const ExecutionModel& model) {
  check_model(model);
  const StandardFloatingPoint mode;
  const Stopwatch watch;
  ExecutedMotion result{.convergence_radius = infinity};
  const ExecutionBounds bounds = bounds_of(functions, problem, model);
  result.most_command = bounds.most_command;
  result.reason = beyond_range(functions, problem.workspace, bounds);
  if (result.reason.empty()) {
    const PerturbationFactory perturbation = perturbations(functions, bounds, false);
    const BranchResult level_set = examine_level_set(functions, problem, perturbation, nullptr);
    result.invariant = level_set.proved;
    result.boxes = level_set.boxes;
    if (result.invariant) {
      BranchLimits limits = level_set_limits();
      limits.max_seconds -= watch.seconds();
      const ConvergenceBall ball = convergence_ball(functions, problem, perturbation, limits);
      result.convergence_radius = ball.radius;
      result.boxes += ball.boxes;
    }
  }
  result.seconds = watch.seconds();
  return result;
}

BranchResult prove_executed_invariance(const ProofFunctions& functions, const SafetyProblem& problem,
                                       const ExecutionModel& model, std::int64_t kept_boxes) {
  check_model(model);
  const StandardFloatingPoint mode;
  const ExecutionBounds bounds = bounds_of(functions, problem, model);
  if (!beyond_range(functions, problem.workspace, bounds).empty()) {
    BranchResult open;
    open.stopped = true;
    open.open_boxes = 1;
    open.open_lower = problem.workspace.lower.transpose();
    open.open_upper = problem.workspace.upper.transpose();
    return open;
  }
  return examine_level_set(functions, problem, perturbations(functions, bounds, false), nullptr, kept_boxes);
}

SpeedRange certified_speeds(const ProofFunctions& functions, const SafetyProblem& problem,
                            const ExecutionModel& model) {
  check_model(model);
  const StandardFloatingPoint mode;
  SpeedRange range;
  double ignored = 0.0;
  const auto holds = [&](double least, double most, double& command) {
    return certifies(functions, problem, model, least, most, command);
  };
  if (!holds(model.least_speed, model.most_speed, range.most_command)) return range;
  range.least = model.least_speed;
  range.most = model.most_speed;
  constexpr double first_step = 1.5, last_step = 1.02, farthest = 1e3;
  if (!(model.window() + model.lag > 0.0)) {  // all else shrinks as the speed grows
    range.most = infinity;
    range.most_command = 0.0;
  } else {
    for (double step = first_step; step > last_step && range.most < farthest;) {
      const double next = range.most * step;
      if (holds(range.most, next, range.most_command))
        range.most = next;
      else
        step = std::sqrt(step);
    }
  }
  if (!(model.velocity_error > 0.0)) {  // all else shrinks with the speed
    range.least = 0.0;
  } else {
    for (double step = first_step; step > last_step && range.least > 1.0 / farthest;) {
      const double next = range.least / step;
      if (holds(next, range.least, ignored))
        range.least = next;
      else
        step = std::sqrt(step);
    }
  }
  return range;
}

Shield prove_shield(const ProofFunctions& functions, const SafetyProblem& problem,
                    const ExecutionModel& model) {
  check_model(model);
  const StandardFloatingPoint mode;
  Shield shield;
  const ExecutionBounds bounds = bounds_of(functions, problem, model);
  if (model.lag > 0.0 || !beyond_range(functions, problem.workspace, bounds).empty()) return shield;
  LevelSetVariation variation;
  variation.distance = (model.position_error + model.window() * bounds.most_rate) * slack;
  const BranchResult found =
      examine_level_set(functions, problem, perturbations(functions, bounds, true), &variation);
  shield.certified = found.proved && variation.value < infinity && variation.gradient < infinity;
  if (!shield.certified) return shield;
  shield.band = variation.value;
  shield.cone = variation.gradient;
  shield.most_command = bounds.most_command;
  return shield;
}

}  // namespace s2nnds
