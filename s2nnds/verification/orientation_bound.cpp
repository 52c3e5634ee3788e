// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/orientation_bound.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/random.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/problem/interval.h"
#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/verification/network_function.h"
#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/standard_floating_point.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kDrawn = 20000;
constexpr std::int64_t kFewBoxes = 100000;  // of an attempt that may fail
// Covers the dozen roundings, each of 2^-53, with which a norm is put together from bounds on its parts.
constexpr double kRounding = 1.0 + 1e-12;

// Boxes where |psi| < most, or B > 0.
class NormExaminer final : public BoxExaminer {
 public:
  NormExaminer(const NetworkFunction& psi, const ProofFunctions& functions, double most)
      : psi_(psi),
        most_(most),
        workspace_(psi.workspace()),
        models_(psi.output_dimension(), psi.input_dimension()),
        barrier_(*functions.B, nullptr),
        tile_(psi.input_dimension()) {}

  void examine(BoxBatch& batch) override {
    for (Eigen::Index first = batch.first; first < batch.first + batch.count; first += tile_boxes) {
      const Eigen::Index count = std::min<Eigen::Index>(tile_boxes, batch.first + batch.count - first);
      tile_.assign(batch.lower, batch.upper, first, count);
      const TileRow norm = upper_norm(), level = barrier_.value(tile_).lower(tile_);
      for (Eigen::Index lane = 0; lane < count; ++lane) {
        BoxStatus& status = batch.status[static_cast<std::size_t>(first + lane)];
        if (norm(lane) < most_) {  // false for NaN
          status = BoxStatus::proved;
        } else if (level(lane) > 0.0) {
          status = BoxStatus::excluded;
        }
      }
    }
  }

 private:
  // Above |psi(x)| on each box.
  TileRow upper_norm() {
    psi_.models(tile_, *workspace_, models_);
    TileRow squares;
    for (Eigen::Index i = 0; i < psi_.output_dimension(); ++i) {
      const TileRow size =
          models_.value(i).abs() + models_.spread(i, tile_) + models_.deviation(i, tile_) + underflow;
      squares += size.square();
    }
    return kRounding * squares.sqrt();
  }

  const NetworkFunction& psi_;
  double most_;
  std::unique_ptr<TaylorFunction::Workspace> workspace_;
  TileModels models_;
  ScalarEnclosure barrier_;
  BoxTile tile_;
};

// The largest |psi| at points drawn from the workspace where B <= 0.
double largest_drawn(const NetworkWeights& psi, const NetworkFunction& enclosed,
                     const ProofFunctions& functions, const SafetyProblem& problem) {
  RandomStream random(0, "orientation-bound");
  const Points drawn = uniform_points(problem.workspace, kDrawn, random);
  const Points value = psi.value(drawn);
  ScalarEnclosure barrier(*functions.B, nullptr);
  BoxTile tile(enclosed.input_dimension());
  double largest = 0.0;
  for (Eigen::Index first = 0; first < drawn.rows(); first += tile_boxes) {
    const Eigen::Index count = std::min<Eigen::Index>(tile_boxes, drawn.rows() - first);
    tile.assign(drawn, drawn, first, count);
    const TileRow level = barrier.value(tile).upper(tile);
    for (Eigen::Index lane = 0; lane < count; ++lane)
      if (level(lane) <= 0.0) largest = std::max(largest, value.row(first + lane).norm());
  }
  return largest;
}

}  // namespace

OrientationBound prove_orientation_bound(const OrientationLaw& law, const ProofFunctions& functions,
                                         const SafetyProblem& problem, const BranchLimits& limits) {
  law.check(problem.dimension());
  const Stopwatch watch;
  const StandardFloatingPoint mode;
  OrientationBound found;
  const Box& workspace = problem.workspace;
  const double reach = std::max(workspace.lower.cwiseAbs().maxCoeff(), workspace.upper.cwiseAbs().maxCoeff());
  const NetworkFunction psi(law.psi);
  found.reason = functions.beyond_range(workspace);
  if (found.reason.empty() && !(psi.growth(reach) <= largest_growth))
    found.reason = "psi magnifies numbers beyond the range for which underflow is covered";
  if (!found.reason.empty()) return found;
  // Every number below it plus the initial error is below pi.
  const double most = (Interval(pi_interval().lower) - Interval(law.initial_error)).lower;
  const double drawn = largest_drawn(law.psi, psi, functions, problem);
  // The largest |psi| is found at few of the drawn points; each attempt costs little but the last.
  for (const double wanted : {1.02 * drawn + 0.01, 1.1 * drawn + 0.01, 1.3 * drawn + 0.01, most}) {
    if (!(wanted <= most && drawn < most) || found.proved) continue;
    BranchLimits left = limits;
    if (wanted < most) left.max_boxes = std::min(left.max_boxes, kFewBoxes);
    left.max_seconds = std::max(1e-9, limits.max_seconds - watch.seconds());
    const BranchResult result = branch_and_bound(
        workspace.lower.transpose(), workspace.upper.transpose(),
        [&] { return std::make_unique<NormExaminer>(psi, functions, wanted); }, left);
    found.boxes += result.boxes;
    found.proved = result.proved;
    if (result.proved) found.bound = wanted;
  }
  if (!found.proved)
    found.reason = drawn < most ? "the bound was left open" : "psi turns too far on the safe set";
  found.seconds = watch.seconds();
  return found;
}

}  // namespace s2nnds
