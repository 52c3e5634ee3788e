// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <vector>

#include "s2nnds/verification/prover.h"

namespace s2nnds {

// Above, and below, |grad y|_2 at every place of each box of the tile.
TileRow gradient_norm(ScalarEnclosure& function, const BoxTile& tile);
TileRow least_gradient_norm(ScalarEnclosure& function, const BoxTile& tile);

// Raises the value to the candidate where that is larger; NaN counts as infinite. For several threads.
void raise_to(std::atomic<double>& value, double candidate);

// Examines boxes tile by tile, with enclosures of B and V along f at hand: in several looks, from the cheapest on. The
// boxes that one look leaves open fill the tiles of the next.
class TileExaminer : public BoxExaminer {
 public:
  // `resolution`: widest side of a box that counts as narrow. The functions must outlive this.
  TileExaminer(const ProofFunctions& functions, double resolution)
      : barrier_(*functions.B, functions.f.get()),
        lyapunov_(*functions.V, functions.f.get()),
        tile_(functions.B->input_dimension()),
        resolution_(resolution) {}

  void examine(BoxBatch& batch) override;

 protected:
  // One box of tile_.
  struct Lane {
    Eigen::Index at;  // in the tile, 0 <= at < tile_boxes
    Eigen::RowVectorXd lower, upper;
    bool narrow;

    double width() const { return (upper - lower).maxCoeff(); }
  };

  virtual void look(int count) = 0;  // at tile_, for the count-th time, from 0
  // What is known of the box after this look; nothing: it needs another one.
  virtual std::optional<BoxStatus> judge(int count, const Lane& lane) = 0;
  // As often as is useful until the form, of a rate, can be negative.
  void cut_for(const TileForm& rate);

  ScalarEnclosure barrier_, lyapunov_;
  BoxTile tile_;
  TileRow carried_;  // of the boxes in tile_: left by the boxes of which they are parts (branch_and_bound.h)
  std::array<std::int32_t, tile_boxes>
      cuts_;                      // how often to bisect these boxes if the look leaves them undecided
  std::array<TileRow, 2> noted_;  // of the boxes in tile_: left by one look to the next

 private:
  double resolution_;
};

}  // namespace s2nnds
