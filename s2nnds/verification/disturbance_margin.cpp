// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/disturbance_margin.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>

#include "s2nnds/core/check.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/verification/convergence_ball.h"
#include "s2nnds/verification/level_set_examiner.h"
#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/standard_floating_point.h"

namespace s2nnds {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Relative width of the last bisection: a margin is stated to a few per cent.
constexpr double tolerance = 0.03;
// Examined in each step, at most: some seconds, after which a smaller disturbance is worth more.
constexpr std::int64_t most_boxes = 500000;
// What a step may take beyond twice the boxes of the first cover.
constexpr std::int64_t spare_boxes = 20000;
// Boxes this small, relative to the workspace, are given up: too early only costs margin.
constexpr double level_resolution = 1e-4;
// For the margin and the ball together.
constexpr double most_seconds = 60.0;

// Boxes that {B = 0} may meet, with bounds that hold on each: |grad B|_2 <= gradient, and Bdot <= rate where B = 0.
// Together with boxes that {B = 0} does not meet they cover the workspace.
struct LevelSetCover {
  struct Member {
    Eigen::RowVectorXd lower, upper;
    double rate, gradient;

    bool withstands(double disturbance) const { return rate + disturbance * gradient * slack < -1e-300; }
  };
  std::vector<Member> members;
  double weakest = -infinity;  // largest -(allowed disturbance) of the members

  void add(const LevelSetCover& part) {
    members.insert(members.end(), part.members.begin(), part.members.end());
    weakest = std::max(weakest, part.weakest);
  }
};

// Bdot + disturbance |grad B| < 0 wherever B = 0. Boxes that are proved join the examiner's own part of the cover.
class CoveringExaminer final : public LevelSetExaminer {
 public:
  CoveringExaminer(const ProofFunctions& functions, double resolution, double disturbance,
                   LevelSetCover& cover)
      : LevelSetExaminer(functions, resolution, std::make_unique<BoundedPerturbation>(1.0), disturbance,
                         infinity),
        cover_(cover) {}

 private:
  void on_proved(const Lane& lane, const Bounds& bounds) override {
    cover_.weakest = std::max(cover_.weakest, bounds.rate / bounds.work);
    cover_.members.push_back({lane.lower, lane.upper, bounds.rate, bounds.work});
  }

  LevelSetCover& cover_;
};

class Search {
 public:
  Search(const ProofFunctions& functions, const SafetyProblem& problem)
      : functions_(functions), problem_(problem) {
    limits_.max_boxes = most_boxes;
    limits_.max_abandoned = 1;  // one that fails is enough to end a step
    limits_.kept_boxes = 0;
  }

  // Whether the barrier withstands the disturbance. If so, the cover does; it can only become finer.
  bool withstands(double disturbance, LevelSetCover& cover) {
    std::vector<LevelSetCover::Member> kept, open;
    for (LevelSetCover::Member& member : cover.members) {
      (member.withstands(disturbance) ? kept : open).push_back(member);
    }
    Points lower(open.size(), problem_.dimension()), upper = lower;
    for (std::size_t i = 0; i < open.size(); ++i) {
      lower.row(static_cast<Eigen::Index>(i)) = open[i].lower;
      upper.row(static_cast<Eigen::Index>(i)) = open[i].upper;
    }
    LevelSetCover parts;
    if (!refine(std::move(lower), std::move(upper), disturbance, parts).proved) return false;
    cover.members = std::move(kept);
    cover.add(parts);
    return true;
  }

  // A cover on which Bdot < 0; none if that cannot be shown.
  std::optional<LevelSetCover> cover() {
    LevelSetCover found;
    const Box& workspace = problem_.workspace;
    if (!refine(workspace.lower.transpose(), workspace.upper.transpose(), 0.0, found).proved)
      return std::nullopt;
    return found;
  }

  void limit_boxes(std::int64_t boxes) { limits_.max_boxes = std::min(most_boxes, boxes); }

  double radius(double disturbance) {
    BranchLimits limits = limits_;
    limits.max_boxes = most_boxes;
    limits.max_seconds = most_seconds - seconds();
    const ConvergenceBall ball = convergence_ball(
        functions_, problem_, [&] { return std::make_unique<BoundedPerturbation>(disturbance); }, limits);
    boxes_ += ball.boxes;
    return ball.radius;
  }

  std::int64_t boxes() const { return boxes_; }
  double seconds() const { return watch_.seconds(); }
  bool out_of_time() const { return seconds() > most_seconds; }

 private:
  double width() const { return (problem_.workspace.upper - problem_.workspace.lower).maxCoeff(); }

  BranchResult refine(Points lower, Points upper, double disturbance, LevelSetCover& cover) {
    const double resolution = level_resolution * width();
    std::deque<LevelSetCover> parts;  // one an examiner, that is one a thread
    BranchResult result = run(std::move(lower), std::move(upper), [&] {
      return std::make_unique<CoveringExaminer>(functions_, resolution, disturbance, parts.emplace_back());
    });
    for (const LevelSetCover& part : parts) cover.add(part);
    return result;
  }

  template <typename Factory>
  BranchResult run(Points lower, Points upper, const Factory& factory) {
    limits_.max_seconds = most_seconds - seconds();
    const BranchResult result = branch_and_bound(
        std::move(lower), std::move(upper), [&]() -> std::unique_ptr<BoxExaminer> { return factory(); },
        limits_);
    boxes_ += result.boxes;
    return result;
  }
  const ProofFunctions& functions_;
  const SafetyProblem& problem_;
  BranchLimits limits_;
  std::int64_t boxes_ = 0;
  Stopwatch watch_;
};

}  // namespace

DisturbanceMargin disturbance_margin(const ProofFunctions& functions, const SafetyProblem& problem) {
  const StandardFloatingPoint mode;
  DisturbanceMargin result;
  result.convergence_radius = infinity;
  if (!functions.beyond_range(problem.workspace).empty()) return result;
  Search search(functions, problem);
  std::optional<LevelSetCover> cover = search.cover();
  if (cover && std::isfinite(cover->weakest)) {
    // Steps start from the cover; one that fails would go on to the limit.
    search.limit_boxes(2 * search.boxes() + spare_boxes);
    // The cover withstands that of its weakest member; what is finer may withstand more.
    double low = 0.0, high = -1.2 * cover->weakest;
    while (high < 1e9 && !search.out_of_time() && search.withstands(high, *cover)) {
      low = high;
      high *= 1.5;
    }
    while (high - low > tolerance * high && high > 1e-9 && !search.out_of_time()) {
      const double middle = 0.5 * (low + high);
      (search.withstands(middle, *cover) ? low : high) = middle;
    }
    result.margin = low;
  }
  result.convergence_radius = result.margin > 0.0 ? search.radius(result.margin) : infinity;
  result.boxes = search.boxes();
  result.seconds = search.seconds();
  return result;
}

double convergence_radius(const ProofFunctions& functions, const SafetyProblem& problem, double disturbance) {
  check(disturbance >= 0.0, "convergence radius: the disturbance is {}, expected >= 0", disturbance);
  const StandardFloatingPoint mode;
  if (!functions.beyond_range(problem.workspace).empty()) return infinity;
  return Search(functions, problem).radius(disturbance);
}

}  // namespace s2nnds
