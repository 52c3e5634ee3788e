// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>

#include "s2nnds/verification/taylor_model.h"

namespace s2nnds {

// What is known of delta in xdot = f(x) + delta. Used by one thread only.
class Perturbation {
 public:
  virtual ~Perturbation() = default;
  // Above grad y . delta on each box of the tile, whatever delta is there.
  virtual TileRow work(ScalarEnclosure& function, const BoxTile& tile) = 0;
};
using PerturbationFactory = std::function<std::unique_ptr<Perturbation>()>;  // one for each thread

// |delta|_2 <= size.
class BoundedPerturbation final : public Perturbation {
 public:
  explicit BoundedPerturbation(double size) : size_(size) {}  // size >= 0
  TileRow work(ScalarEnclosure& function, const BoxTile& tile) override;

 private:
  double size_;
};

}  // namespace s2nnds
