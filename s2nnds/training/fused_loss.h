// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "s2nnds/networks/fused_network.h"
#include "s2nnds/training/loss_part.h"

namespace s2nnds {

// Points of a batch [count, n], row-major, in memory that somebody else owns.
template <typename T>
struct PointsView {
  const T* data = nullptr;   // [count * n]
  std::ptrdiff_t count = 0;  // may be 0
};

// The points of one training step without a copy; T is float or double.
template <typename T>
using BatchView = BatchOf<PointsView<T>>;

// A network's layers and what is made of their output.
struct NetworkShape {
  std::vector<LayerShape> layers;  // from input to output
  Head head = Head::plain;         // what is made of the last layer's output
  double quadratic = 0.0;          // eps_V of squared_norm, >= 0; else unused
};

// A table's loss and its gradients in closed form, in one pass over the batch: every tile of samples goes
// forward through the networks it concerns, its loss is differentiated, and it goes back, all in cache. Tiles
// are shared out over a fixed number of chunks, whose gradients are summed in order, so that the result does
// not depend on the number of threads. f may be zero_at_origin or plain, V a sum of squares or plain, B plain.
template <typename T>
class FusedLoss {
 public:
  // Makes the plan of the computation once; throws Error where the shapes do not fit each other.
  FusedLoss(const NetworkShape& f, const NetworkShape& V, const NetworkShape& B, const LossTable& table,
            const LossOptions& options, const Trains& trains = {});
  ~FusedLoss();
  FusedLoss(const FusedLoss&) = delete;
  FusedLoss& operator=(const FusedLoss&) = delete;

  // Returns the terms, each with its weight applied, and writes the gradients of their sum in the flat
  // parameters of f, V and B, zero for one that does not train. Nothing is computed for a term of weight 0.
  PerTerm<double> run(const T* theta_f, const T* theta_V, const T* theta_B, const BatchView<T>& batch,
                      T* gradient_f, T* gradient_V, T* gradient_B);

 private:
  struct Chunk;
  // What is to be done with the samples of one set.
  struct Pass {
    std::vector<LossPart> parts;
    Quantities needs;
    double cost = 0.0;  // products a sample
  };
  // A tile of samples.
  struct Work {
    Samples set;
    std::ptrdiff_t first, rows;
    double cost;
  };

  void share_out(const BatchView<T>& batch);
  void take_origins();
  void run_tile(Chunk& chunk, const Work& work, const BatchView<T>& batch) const;
  // J_f at the tile's samples, where LossOptions::execution needs it.
  void take_jacobian(Chunk& chunk, const Quantities& needs, const T* x, std::ptrdiff_t rows) const;
  // f(x) with what LossOptions::execution adds to it at worst for V or B: the direction of Vdot and Bdot.
  const T* direction_of_V(Chunk& chunk, const Quantities& needs, const T* x, std::ptrdiff_t rows) const;
  const T* direction_of_B(Chunk& chunk, const Quantities& needs, const T* x, std::ptrdiff_t rows) const;
  // f(x) projected as LossOptions::projection says, from chunk's V and its features.
  const T* projected_velocity(Chunk& chunk, const Quantities& needs, const T* x, std::ptrdiff_t rows) const;
  void perturb(Chunk& chunk, std::ptrdiff_t rows, std::vector<T>& directions) const;
  void finish_V(Chunk& chunk, bool wants_V_dot, const T* x, const T* direction, std::ptrdiff_t rows) const;
  void start_back_V(Chunk& chunk, const Quantities& needs, std::ptrdiff_t rows) const;
  void run_origins();

  NetworkShape shape_f_, shape_V_;
  LossOptions options_;
  Trains trains_;
  std::ptrdiff_t dimension_;
  FusedNetwork<T> f_, V_, B_;
  std::array<Pass, all_samples.size()> passes_;
  std::vector<T> origin_, f_at_origin_, V_at_origin_;
  std::vector<std::unique_ptr<Chunk>> chunks_;
};

}  // namespace s2nnds
