// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "s2nnds/training/batch.h"
#include "s2nnds/training/trainer_options.h"

namespace at {
class Tensor;
}

namespace s2nnds {

// Some of what the networks are at a sample. Dots are derivatives along f.
struct Quantities {
  bool f = false, V = false, V_dot = false, B = false, B_dot = false;

  bool any_f() const { return f || V_dot || B_dot; }
  bool any_V() const { return V || V_dot; }
  bool any_B() const { return B || B_dot; }
  Quantities operator|(const Quantities& o) const {
    return {f || o.f, V || o.V, V_dot || o.V_dot, B || o.B, B_dot || o.B_dot};
  }
};

// The quantities at a set's samples as tensors, for the autograd engine: loss_tensors.h.
struct SampleTensors;

// One sample, for the fused engine: the quantities there, and where the derivatives of the loss in them are
// added up.
template <typename T>
struct Sample {
  std::ptrdiff_t dimension;
  const T* f;       // [n]
  const T* beside;  // [n]: a demonstration's velocity, a boundary point's normal
  T* by_f;          // [n]
  double V, V_dot, B, B_dot;
  double &by_V, &by_V_dot, &by_B, &by_B_dot;
};

// Samples [rows] whose quantities lie side by side.
template <typename T>
struct Tile {
  std::ptrdiff_t rows, dimension;
  const T *f, *beside;
  T* by_f;
  const double *V, *V_dot, *B, *B_dot;
  double *by_V, *by_V_dot, *by_B, *by_B_dot;

  Sample<T> operator[](std::ptrdiff_t s) const {
    return {dimension,
            f + s * dimension,
            beside ? beside + s * dimension : nullptr,
            by_f + s * dimension,
            V[s],
            V_dot[s],
            B[s],
            B_dot[s],
            by_V[s],
            by_V_dot[s],
            by_B[s],
            by_B_dot[s]};
  }
};

// The mean of a penalty over a set of samples. A term of the loss is the sum of its parts.
struct LossPart {
  LossTerm term;
  Samples samples;
  Quantities needs;     // what the penalty is computed from
  Quantities constant;  // of these, what counts as constant: the loss has no derivative in it
  // The penalties [N], by torch operations.
  at::Tensor (*values)(const LossOptions& options, const SampleTensors& at);
  // Their sum over a tile; adds `weight` times their derivatives.
  double (*sum_float)(const LossOptions& options, double weight, const Tile<float>& tile);
  double (*sum_double)(const LossOptions& options, double weight, const Tile<double>& tile);
};
using LossTable = std::vector<LossPart>;

// Whose gradients are wanted. For the barrier's alone, parts without B are left out.
enum class Trains { all, barrier };

// Nothing is computed for a part that does not apply.
inline bool applies(const LossPart& part, const LossOptions& options, Trains trains) {
  return options.weight[part.term] > 0.0 && (trains == Trains::all || part.needs.any_B());
}

template <typename Penalty, typename T>
double sum_over(const LossOptions& options, double weight, const Tile<T>& tile) {
  double sum = 0.0;
  for (std::ptrdiff_t s = 0; s < tile.rows; ++s) sum += Penalty::value(options, weight, tile[s]);
  return sum;
}

// A penalty is a struct with
//   static constexpr Quantities needs, and constant if there are any;
//   static torch::Tensor values(const LossOptions&, const SampleTensors&): the penalties [N];
//   template <typename T> static double value(const LossOptions&, double weight, const Sample<T>&): that of
//   one sample, adding weight times its derivatives to the sample's by_*. Comparisons must let NaN through,
//   so that it ends the training instead of looking like a condition that is met.
template <typename Penalty>
LossPart loss_part(LossTerm term, Samples samples) {
  LossPart part{term,
                samples,
                Penalty::needs,
                {},
                Penalty::values,
                sum_over<Penalty, float>,
                sum_over<Penalty, double>};
  if constexpr (requires { Penalty::constant; }) part.constant = Penalty::constant;
  return part;
}

// relu(z) or, with a leak, the leaky ReLU, and its derivative. NaN goes through.
struct Rectified {
  double value, slope;
};
inline Rectified rectified(double z, double leak = 0.0) {
  return z <= 0.0 ? Rectified{leak * z, leak} : Rectified{z, 1.0};
}

}  // namespace s2nnds
