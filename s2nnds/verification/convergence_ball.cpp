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

// grad V . (f + delta) < 0 in {B <= 0}; where that cannot be shown, `level` is raised to V.
class DescentExaminer final : public TileExaminer {
 public:
  DescentExaminer(const ProofFunctions& functions, double resolution,
                  std::unique_ptr<Perturbation> perturbation, std::atomic<double>& level)
      : TileExaminer(functions, resolution), perturbation_(std::move(perturbation)), level_(level) {}

 private:
  void evaluate() override {
    outside_ = barrier_.value(tile_).lower(tile_) > 0.0;
    if (outside_.all()) return;
    rate_ = lyapunov_.lie_derivative(tile_).upper(tile_);
    if ((!outside_ && rate_ < 0.0).any()) rate_ += perturbation_->work(lyapunov_, tile_);
    value_ = lyapunov_.value(tile_).upper(tile_);
  }
  BoxStatus judge(Eigen::Index lane, const Eigen::RowVectorXd&, const Eigen::RowVectorXd&,
                  bool narrow) override {
    if (outside_(lane) || rate_(lane) < -1e-300 || value_(lane) <= level_) return BoxStatus::proved;
    if (!narrow) return BoxStatus::undecided;
    raise_to(level_, value_(lane));
    return BoxStatus::abandoned;
  }

  std::unique_ptr<Perturbation> perturbation_;
  std::atomic<double>& level_;
  TileRow rate_, value_;
  Eigen::Array<bool, tile_boxes, 1> outside_;
};

// The ball around {V <= level} in {B <= 0}: `radius` is raised to hold every box that is not shown to lie
// outside.
class SublevelExaminer final : public TileExaminer {
 public:
  SublevelExaminer(const ProofFunctions& functions, double resolution, double level,
                   std::atomic<double>& radius)
      : TileExaminer(functions, resolution), level_(level), radius_(radius) {}

 private:
  void evaluate() override {
    outside_ = barrier_.value(tile_).lower(tile_) > 0.0;
    const TileForm& value = lyapunov_.value(tile_);
    outside_ = outside_ || value.lower(tile_) > level_;
    inside_ = value.upper(tile_) <= level_;
  }
  BoxStatus judge(Eigen::Index lane, const Eigen::RowVectorXd& lower, const Eigen::RowVectorXd& upper,
                  bool narrow) override {
    const double reach = lower.cwiseAbs().cwiseMax(upper.cwiseAbs()).norm() * slack;
    if (outside_(lane) || reach <= radius_) return BoxStatus::proved;
    if (!inside_(lane) && !narrow) return BoxStatus::undecided;
    raise_to(radius_, reach);
    return BoxStatus::proved;
  }

  double level_;
  std::atomic<double>& radius_;
  Eigen::Array<bool, tile_boxes, 1> outside_, inside_;
};

}  // namespace

TileRow BoundedPerturbation::work(ScalarEnclosure& function, const BoxTile& tile) {
  return size_ * gradient_norm(function, tile) * slack;
}

ConvergenceBall convergence_ball(const ProofFunctions& functions, const SafetyProblem& problem,
                                 const PerturbationFactory& perturbation, BranchLimits limits) {
  const Box& workspace = problem.workspace;
  const double resolution = ball_resolution * (workspace.upper - workspace.lower).maxCoeff();
  limits.max_abandoned = std::numeric_limits<std::int64_t>::max();
  std::atomic<double> level = 0.0, radius = 0.0;
  ConvergenceBall ball{.radius = infinity};
  const auto run = [&](const std::function<std::unique_ptr<BoxExaminer>()>& examiner) {
    const BranchResult found =
        branch_and_bound(workspace.lower.transpose(), workspace.upper.transpose(), examiner, limits);
    ball.boxes += found.boxes;
    limits.max_seconds -= found.seconds;
    return found;
  };
  const BranchResult descent = run([&]() -> std::unique_ptr<BoxExaminer> {
    return std::make_unique<DescentExaminer>(functions, resolution, perturbation(), level);
  });
  // Abandoned boxes lie in the sublevel set by now; boxes that a limit left open do not.
  if (descent.stopped || !(level < infinity)) return ball;
  const double found = level;
  const BranchResult sublevel = run([&]() -> std::unique_ptr<BoxExaminer> {
    return std::make_unique<SublevelExaminer>(functions, resolution, found, radius);
  });
  if (sublevel.proved) ball.radius = radius;
  return ball;
}

}  // namespace s2nnds
