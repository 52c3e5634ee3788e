// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>

#include "s2nnds/verification/prover.h"

namespace s2nnds {

// Above |grad y|_2 on each box of the tile.
TileRow gradient_norm(ScalarEnclosure& function, const BoxTile& tile);

// Raises the value to the candidate where that is larger; NaN counts as infinite. For several threads.
void raise_to(std::atomic<double>& value, double candidate);

// Examines boxes tile by tile, with enclosures of B and V along f at hand.
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
  virtual void evaluate() = 0;  // on tile_
  // What is known of the box in this lane of tile_.
  virtual BoxStatus judge(Eigen::Index lane, const Eigen::RowVectorXd& lower, const Eigen::RowVectorXd& upper,
                          bool narrow) = 0;

  ScalarEnclosure barrier_, lyapunov_;
  BoxTile tile_;

 private:
  double resolution_;
};

}  // namespace s2nnds
