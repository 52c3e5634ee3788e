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

// Some of what the networks are at a sample. Dots are derivatives along f; where LossOptions::execution asks
// for more, along f plus the perturbation that raises V or B most, held constant. That gives the gradient in
// V and B of the rate of the worst motion exactly (Danskin's theorem); in f it leaves out how the
// perturbation changes with f.
struct Quantities {
  bool f = false,     // f(x)
      V = false,      // V(x)
      V_dot = false,  // grad V(x) . f(x)
      B = false,      // B(x)
      B_dot = false;  // grad B(x) . f(x)

  bool any_f() const { return f || V_dot || B_dot; }  // whether f must be computed
  bool any_V() const { return V || V_dot; }           // whether V must be computed
  bool any_B() const { return B || B_dot; }           // whether B must be computed
  // What at least one of the two needs.
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
  std::ptrdiff_t dimension;  // n
  const T* f;                // f(x), [n]
  const T* beside;           // [n]: a demonstration's velocity, a boundary point's normal
  T* by_f;                   // [n]: derivatives of the loss in f(x)
  double V,                  // V(x)
      V_dot,                 // grad V(x) . f(x)
      B,                     // B(x)
      B_dot;                 // grad B(x) . f(x)
  double &by_V,              // derivative of the loss in V
      &by_V_dot,             // in V_dot
      &by_B,                 // in B
      &by_B_dot;             // in B_dot
};

// Neighbouring samples of one set; their quantities lie one behind the other in memory.
template <typename T>
struct Tile {
  std::ptrdiff_t rows,  // number of samples
      dimension;        // n
  const T *f,           // f at the samples, [rows, n]
      *beside;          // [rows, n], or null for a set that has nothing beside its points
  T* by_f;              // [rows, n]: derivatives of the loss in f
  const double *V,      // V(x), [rows]
      *V_dot,           // grad V(x) . f(x), [rows]
      *B,               // B(x), [rows]
      *B_dot;           // grad B(x) . f(x), [rows]
  double *by_V,         // derivatives of the loss in V, [rows]
      *by_V_dot,        // in V_dot, [rows]
      *by_B,            // in B, [rows]
      *by_B_dot;        // in B_dot, [rows]

  // Sample s, 0 <= s < rows; it refers to the tile's memory.
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
  LossTerm term;        // the term that it is a part of, which gives its weight
  Samples samples;      // the set that it is a mean over
  Quantities needs;     // what the penalty is computed from
  Quantities constant;  // of these, what counts as constant: the loss has no derivative in it
  // The penalties [N], by torch operations.
  at::Tensor (*values)(const LossOptions& options, const SampleTensors& at);
  // The sum of the penalties over a tile; adds `weight` times their derivatives to the tile's by_*.
  double (*sum_float)(const LossOptions& options, double weight, const Tile<float>& tile);
  // The same in double.
  double (*sum_double)(const LossOptions& options, double weight, const Tile<double>& tile);
};
// All parts of a loss.
using LossTable = std::vector<LossPart>;

// Whose gradients are wanted; the others are constant. What trains f trains V and B, too: it moves what they hold of.
struct Trains {
  bool f = true, V = true, B = true;

  static Trains barrier() { return {.f = false, .V = false, .B = true}; }
};

// Whether a part counts: its weight is not 0, and it concerns a network that trains. Nothing is computed for
// other parts.
inline bool applies(const LossPart& part, const LossOptions& options, const Trains& trains) {
  return options.weight[part.term] > 0.0 &&
         (trains.f || (trains.V && part.needs.any_V()) || (trains.B && part.needs.any_B()));
}

// The sum of a penalty over a tile, as LossPart::sum_float and sum_double want it.
template <typename Penalty, typename T>
double sum_over(const LossOptions& options, double weight, const Tile<T>& tile) {
  double sum = 0.0;
  for (std::ptrdiff_t s = 0; s < tile.rows; ++s) sum += Penalty::value(options, weight, tile[s]);
  return sum;
}

// The part of the loss that a penalty makes. A penalty is a struct with these static members:
// - `needs`, and `constant` if anything is: constexpr Quantities, as in LossPart;
// - `values(options, at)`: the penalties [N] as a tensor, `at` a SampleTensors;
// - `value(options, weight, at)`: the penalty of one sample, `at` a Sample of float or double; it adds weight
//   times the derivatives to the sample's by_*.
//
// Comparisons must let NaN through, so that NaN ends the training and does not look like a condition that is
// met.
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

// What rectified() returns.
struct Rectified {
  double value,  // of the function
      slope;     // its derivative
};
// The leaky ReLU of z, max(z, leak z) with 0 <= leak <= 1 (relu where leak is 0). NaN goes through.
inline Rectified rectified(double z, double leak = 0.0) {
  return z <= 0.0 ? Rectified{leak * z, leak} : Rectified{z, 1.0};
}

}  // namespace s2nnds
