// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/level_distance.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "s2nnds/core/check.h"
#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/standard_floating_point.h"
#include "s2nnds/verification/tile_examiner.h"

namespace s2nnds {
namespace {

// Of the cover's boxes, relative to the workspace: distances are told to this much.
constexpr double resolution_2d = 0.002, resolution_3d = 0.01;
constexpr std::int64_t most_boxes = 1000000;
constexpr double most_seconds = 20.0;

// Boxes that {B = 0} may meet, once they are narrow, join this examiner's part of the cover.
class CoverExaminer final : public TileExaminer {
 public:
  CoverExaminer(const ProofFunctions& functions, double resolution, std::vector<Box>& cover)
      : TileExaminer(functions, resolution), cover_(cover) {}

 private:
  void look(int) override {
    const TileForm& value = barrier_.value(tile_);
    meets_ = !((value.lower(tile_) > 0.0) || (value.upper(tile_) < 0.0));
  }
  std::optional<BoxStatus> judge(int, const Lane& lane) override {
    if (!meets_(lane.at)) return BoxStatus::proved;
    if (!lane.narrow) return BoxStatus::undecided;
    cover_.push_back({lane.lower.transpose(), lane.upper.transpose()});
    return BoxStatus::proved;
  }

  std::vector<Box>& cover_;
  Eigen::Array<bool, tile_boxes, 1> meets_;
};

}  // namespace

LevelDistance::LevelDistance(const ProofFunctions& functions, const SafetyProblem& problem)
    : functions_(functions), workspace_(problem.workspace) {
  if (!functions.beyond_range(workspace_).empty()) return;
  const StandardFloatingPoint mode;
  BranchLimits limits;
  limits.max_boxes = most_boxes;
  limits.max_seconds = most_seconds;
  limits.kept_boxes = 0;
  const double resolution = (workspace_.dimension() <= 2 ? resolution_2d : resolution_3d) *
                            (workspace_.upper - workspace_.lower).maxCoeff();
  std::deque<std::vector<Box>> parts;  // one an examiner, that is one a thread
  const BranchResult found = branch_and_bound(
      workspace_.lower.transpose(), workspace_.upper.transpose(),
      [&] { return std::make_unique<CoverExaminer>(functions, resolution, parts.emplace_back()); }, limits);
  complete_ = found.proved;
  for (const std::vector<Box>& part : parts) cover_.insert(cover_.end(), part.begin(), part.end());
}

// 1 where B < 0 is certain, else 0.
Vector LevelDistance::inside(const Points& x) const {
  ScalarEnclosure barrier(*functions_.B, nullptr);
  BoxTile tile(x.cols());
  Vector found(x.rows());
  for (Eigen::Index first = 0; first < x.rows(); first += tile_boxes) {
    const Eigen::Index count = std::min<Eigen::Index>(tile_boxes, x.rows() - first);
    tile.assign(x, x, first, count);
    const TileRow high = barrier.value(tile).upper(tile);
    for (Eigen::Index lane = 0; lane < count; ++lane) found[first + lane] = high(lane) < 0.0 ? 1.0 : 0.0;
  }
  return found;
}

Vector LevelDistance::below(const Points& x) const {
  check(x.cols() == workspace_.dimension(), "level distance: found points of dimension {}, expected {}",
        x.cols(), workspace_.dimension());
  if (!complete_) return Vector::Zero(x.rows());
  const StandardFloatingPoint mode;
  Vector distance = inside(x);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    if (!(distance[i] > 0.0)) continue;
    const Vector at = x.row(i).transpose();
    double least = (at - workspace_.lower).cwiseMin(workspace_.upper - at).minCoeff();
    for (const Box& box : cover_)
      least = std::min(least, (box.lower - at).cwiseMax(at - box.upper).cwiseMax(0.0).norm());
    distance[i] = std::max(0.0, least * (2.0 - slack) - underflow);
  }
  return distance;
}

}  // namespace s2nnds
