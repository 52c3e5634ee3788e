// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/convergence_ball.h"

#include <atomic>
#include <cmath>
#include <limits>

#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/tile_examiner.h"

namespace s2nnds {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Boxes this small, relative to the workspace, are given up: the ball is told to the size of a box.
constexpr double ball_resolution = 0.004;

// Probes of the level a side, at most; all of them together cost less than the first boxes do.
constexpr double most_probes = 100.0;

// Farther than this times the farthest place at which descent failed nearly nothing lies below V's level there.
constexpr double most_between = 3.0;

// What is known of V's level below which descent is not asked for. For several threads.
struct LevelSearch {
  std::atomic<double> level = 0.0;
  // V at a place of {B <= 0} that is so far from the goal that a ball with it is not worth telling.
  double useless = infinity;
  // How far from the goal, in |x|_2, boxes are asked whether they lie below the level: others hardly do, and V costs time.
  std::atomic<double> near = 0.0;

  // For a place so far from the goal. Infinite, so that nothing more is asked for, once it is useless.
  void raise(double value, double distance) {
    raise_to(level, value < useless ? value : infinity);
    raise_to(near, most_between * distance);
  }
};

// Raises the level to V at places, of a grid, where the perturbation may win.
void probe(const ProofFunctions& functions, const Box& workspace, double useless_radius,
           Perturbation& perturbation, LevelSearch& search) {
  const Eigen::Index n = workspace.dimension();
  const auto side = static_cast<Eigen::Index>(
      std::max(2.0, std::floor(std::pow(most_probes, 1.0 / static_cast<double>(n)))));
  Eigen::Index count = 1;
  for (Eigen::Index d = 0; d < n; ++d) count *= side;
  Points x(count, n);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index d = 0, rest = i; d < n; ++d, rest /= side) {
      x(i, d) = workspace.lower(d) + (workspace.upper(d) - workspace.lower(d)) *
                                         (static_cast<double>(rest % side) + 0.5) / static_cast<double>(side);
    }
  }
  ScalarEnclosure barrier(*functions.B, nullptr), lyapunov(*functions.V, functions.f.get());
  BoxTile tile(n);
  std::vector<std::pair<double, double>> failing;  // V and |x|_2
  for (Eigen::Index first = 0; first < count; first += tile_boxes) {
    const Eigen::Index boxes = std::min<Eigen::Index>(tile_boxes, count - first);
    tile.assign(x, x, first, boxes);
    const auto inside = (barrier.value(tile).upper(tile) <= 0.0).eval();
    if (!inside.any()) continue;
    const TileRow value = lyapunov.value(tile).upper(tile);
    const TileRow rate = lyapunov.lie_derivative(tile).upper(tile) + perturbation.work(lyapunov, tile);
    for (Eigen::Index lane = 0; lane < boxes; ++lane) {
      if (!inside(lane)) continue;
      const double distance = x.row(first + lane).norm();
      if (distance >= useless_radius) search.useless = std::min(search.useless, value(lane));
      if (!(rate(lane) < 0.0)) failing.emplace_back(value(lane), distance);
    }
  }
  for (const auto& [value, distance] : failing) search.raise(value, distance);
}

// grad V . (f + delta) < 0 in {B <= 0}; where that cannot be shown, the level is raised to V.
class DescentExaminer final : public TileExaminer {
 public:
  DescentExaminer(const ProofFunctions& functions, double resolution,
                  std::unique_ptr<Perturbation> perturbation, LevelSearch& search)
      : TileExaminer(functions, resolution), perturbation_(std::move(perturbation)), search_(search) {}

 private:
  // B, the rate along f, where that falls what the perturbation adds, and at last V.
  void look(int count) override {
    if (count == 0) {
      low_ = barrier_.value(tile_).lower(tile_);
    } else if (count == 1) {
      const TileForm& form = lyapunov_.lie_derivative(tile_);
      rate() = form.upper(tile_);
      cut_for(form);
    } else if (count == 2) {
      const TileRow own = perturbation_->work(lyapunov_, tile_);
      carried_ = (own < carried_).select(own, carried_);
    } else {
      value_ = lyapunov_.value(tile_).upper(tile_);
    }
  }
  std::optional<BoxStatus> judge(int count, const Lane& lane) override {
    const Eigen::Index at = lane.at;
    if (count == 0) return low_(at) > 0.0 ? std::optional(BoxStatus::proved) : std::nullopt;
    if (count < 3) {
      if (rate()(at) + carried_(at) * slack < -1e-300) return BoxStatus::proved;
      if (lane.narrow || is_near(lane) || (count == 1 && rate()(at) < 0.0)) return std::nullopt;
      return BoxStatus::undecided;
    }
    if (value_(at) <= search_.level) return BoxStatus::proved;
    if (!lane.narrow) return BoxStatus::undecided;
    search_.raise(value_(at), lane.upper.cwiseMax(-lane.lower).norm());
    return BoxStatus::abandoned;
  }

  // Whether the box comes near enough to the goal for its place below V's level to be looked at.
  bool is_near(const Lane& lane) const {
    return lane.lower.cwiseMax(-lane.upper).cwiseMax(0.0).norm() <= search_.near;
  }

  TileRow& rate() { return noted_[0]; }  // largest one on the boxes

  std::unique_ptr<Perturbation> perturbation_;
  LevelSearch& search_;
  TileRow low_, value_;
};

// The ball around {V <= level} in {B <= 0}: `radius` is raised to hold every box that is not shown to lie
// outside.
class SublevelExaminer final : public TileExaminer {
 public:
  SublevelExaminer(const ProofFunctions& functions, double resolution, double level,
                   std::atomic<double>& radius)
      : TileExaminer(functions, resolution), level_(level), radius_(radius) {}

 private:
  void look(int count) override {
    if (count == 0) {
      outside_ = barrier_.value(tile_).lower(tile_) > 0.0;
    } else {
      const TileForm& value = lyapunov_.value(tile_);
      outside_ = value.lower(tile_) > level_;
      inside_ = value.upper(tile_) <= level_;
    }
  }
  std::optional<BoxStatus> judge(int count, const Lane& lane) override {
    const double reach = lane.lower.cwiseAbs().cwiseMax(lane.upper.cwiseAbs()).norm() * slack;
    if (outside_(lane.at) || reach <= radius_) return BoxStatus::proved;
    if (count == 0) return std::nullopt;
    if (!inside_(lane.at) && !lane.narrow) return BoxStatus::undecided;
    raise_to(radius_, reach);
    return BoxStatus::proved;
  }

  double level_;
  std::atomic<double>& radius_;
  Eigen::Array<bool, tile_boxes, 1> outside_, inside_;
};

}  // namespace

ConvergenceBall convergence_ball(const ProofFunctions& functions, const SafetyProblem& problem,
                                 const PerturbationFactory& perturbation, BranchLimits limits) {
  const Box& workspace = problem.workspace;
  const double resolution = ball_resolution * (workspace.upper - workspace.lower).maxCoeff();
  limits.max_abandoned = std::numeric_limits<std::int64_t>::max();
  LevelSearch search;
  const double useless_radius = workspace.half_widths().minCoeff();
  probe(functions, workspace, useless_radius, *perturbation(), search);
  std::atomic<double> radius = 0.0;
  ConvergenceBall ball{.radius = infinity};
  if (!(search.level < infinity)) return ball;
  const auto run = [&](const std::function<std::unique_ptr<BoxExaminer>()>& examiner) {
    const BranchResult found =
        branch_and_bound(workspace.lower.transpose(), workspace.upper.transpose(), examiner, limits);
    ball.boxes += found.boxes;
    limits.max_seconds -= found.seconds;
    return found;
  };
  const BranchResult descent = run([&]() -> std::unique_ptr<BoxExaminer> {
    return std::make_unique<DescentExaminer>(functions, resolution, perturbation(), search);
  });
  // Abandoned boxes lie in the sublevel set by now; boxes that a limit left open do not.
  if (descent.stopped || !(search.level < infinity)) return ball;
  const double found = search.level;
  const BranchResult sublevel = run([&]() -> std::unique_ptr<BoxExaminer> {
    return std::make_unique<SublevelExaminer>(functions, resolution, found, radius);
  });
  if (sublevel.proved && radius < useless_radius) ball.radius = radius;
  return ball;
}

}  // namespace s2nnds
