// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/supremum.h"

#include <atomic>
#include <cmath>
#include <limits>

#include "s2nnds/verification/tile_examiner.h"

namespace s2nnds {
namespace {

// What the result may be above the largest size seen, beyond which nothing is bisected for.
constexpr double tolerance = 0.02;
// Boxes are not bisected once so many of their size cover the workspace.
constexpr double inside_boxes = 4096.0, level_set_boxes = 62500.0;
constexpr std::int64_t most_boxes = 500000;

class SupremumExaminer final : public TileExaminer {
 public:
  // What is known of all boxes; `enough` changes between the levels only, so that threads do not matter.
  struct Search {
    BarrierSet set;
    double enough = 0.0;
    std::atomic<double> seen = 0.0, found = 0.0;
  };

  SupremumExaminer(const ProofFunctions& functions, double resolution, TileSize size, Search& search)
      : TileExaminer(functions, resolution),
        size_of_(std::move(size)),
        search_(search),
        near_(4.0 * resolution) {}

 private:
  void look(int count) override {
    if (count == 0) {
      const TileForm& barrier = barrier_.value(tile_);
      const TileRow low = barrier.lower(tile_), high = barrier.upper(tile_);
      outside_ = low > 0.0;
      if (search_.set == BarrierSet::level_set) outside_ = outside_ || high < 0.0;
      noted_[0] = high;
    } else if (count == 1) {
      size_ = size_of_(tile_);
    } else {
      BoxTile middle = tile_;
      for (TileRow& half : middle.half) half.setZero();
      size_ = size_of_(middle);
    }
  }
  std::optional<BoxStatus> judge(int count, const Lane& lane) override {
    const double size = size_(lane.at);
    if (count == 0) return outside_(lane.at) ? std::optional(BoxStatus::proved) : std::nullopt;
    if (count == 1) {
      if (!(size <= search_.enough) && !lane.narrow) return std::nullopt;
      raise_to(search_.found, size);
      return BoxStatus::proved;
    }
    // A centre that is not in the set only makes the result larger.
    const bool counts = search_.set == BarrierSet::inside ? noted_[0](lane.at) <= 0.0 : lane.width() <= near_;
    if (counts && size < std::numeric_limits<double>::infinity()) raise_to(search_.seen, size);
    return BoxStatus::undecided;
  }

  TileSize size_of_;
  Search& search_;
  double near_;
  TileRow size_;
  Eigen::Array<bool, tile_boxes, 1> outside_;
};

}  // namespace

double supremum(const ProofFunctions& functions, const Box& workspace, BarrierSet set,
                const std::function<TileSize()>& size) {
  SupremumExaminer::Search search;
  search.set = set;
  BranchLimits limits;
  limits.max_boxes = most_boxes;
  limits.kept_boxes = 0;
  const double smallest = set == BarrierSet::inside ? inside_boxes : level_set_boxes;
  const double resolution = (workspace.upper - workspace.lower).maxCoeff() *
                            std::pow(smallest, -1.0 / static_cast<double>(workspace.dimension()));
  const BranchResult result = branch_and_bound(
      workspace.lower.transpose(), workspace.upper.transpose(),
      [&] { return std::make_unique<SupremumExaminer>(functions, resolution, size(), search); }, limits,
      [&](const BranchProgress&) { search.enough = (1.0 + tolerance) * search.seen; });
  return result.proved ? search.found.load() : std::numeric_limits<double>::infinity();
}

}  // namespace s2nnds
