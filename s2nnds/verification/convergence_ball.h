// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>

#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/verification/prover.h"

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

// The ball around the goal that motions xdot = f(x) + delta converge to.
struct ConvergenceBall {
  // Outside of a sublevel set of V whose part in {B <= 0} lies in |x|_2 <= radius, grad V . (f + delta) < 0 in
  // {B <= 0}. Infinite if that cannot be shown, or only for a ball that is as wide as the workspace.
  double radius = 0.0;
  std::int64_t boxes = 0;  // examined
};

// Sound in floating point; the caller's thread must compute as StandardFloatingPoint says.
ConvergenceBall convergence_ball(const ProofFunctions& functions, const SafetyProblem& problem,
                                 const PerturbationFactory& perturbation, BranchLimits limits);

}  // namespace s2nnds
