// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "s2nnds/networks/activation.h"

namespace s2nnds {

// Boxes are examined in tiles: every number of a Taylor model is a row of `tile_boxes` doubles, one a box, so
// that all arithmetic runs over contiguous lanes.
inline constexpr std::ptrdiff_t tile_boxes = 8;

// What an activation looks like on |z - z0| <= radius, T = tile_boxes lanes each, in exact arithmetic:
//   |sigma(z) - value - first (z - z0) - second (z - z0)^2 / 2| <= value_error
//   |sigma(z) - value - first (z - z0)| <= linear_error
//   |sigma'(z) - first - second (z - z0) - third (z - z0)^2 / 2| <= first_error
//   |sigma(z) - value - first (z - z0) - second (z - z0)^2 / 2 - third (z - z0)^3 / 6| <= value_rest
//   |sigma'(z) - first - second (z - z0) - third (z - z0)^2 / 2 - fourth (z - z0)^3 / 6| <= first_rest
// All roundings are covered, those of the coefficients included. At a jump of sigma'' (elu at 0) the errors
// are of lower order in the radius. A coefficient is not a number where z0 is not.
struct ActivationExpansion {
  double value[tile_boxes],        // sigma at z0, rounded
      first[tile_boxes],           // its first derivative
      second[tile_boxes],          // its second derivative
      third[tile_boxes],           // its third derivative
      fourth[tile_boxes];          // its fourth derivative, or 0 where that gives the smaller first_rest
  double value_error[tile_boxes],  // bound of the first line above
      linear_error[tile_boxes],    // bound of the second line
      first_error[tile_boxes],     // bound of the third line
      value_rest[tile_boxes],      // bound of the fourth line
      first_rest[tile_boxes];      // bound of the fifth line
};

// What a backward sweep keeps of an expansion: first, second, third, fourth, value_rest, first_rest.
inline constexpr std::ptrdiff_t kept_rows = 6;

// One layer of a network on a tile of boxes |x - c| <= half. A stream is a quantity that the network carries
// (the value; the value and its derivative along a direction); its second-order model is value, n slopes and
// the upper triangle of the Hessian, C = 1 + n + n (n + 1) / 2 columns [C, T], and a remainder [T].
struct LayerTile {
  std::ptrdiff_t width = 0;                      // neurons
  std::ptrdiff_t dimension = 0;                  // n
  std::ptrdiff_t streams = 1;                    // 1, and 1 for each derivative
  Activation activation = Activation::identity;  // sigma, applied to each neuron
  const double* half = nullptr;                  // [n, T] half-widths of the boxes
  const double* row_error = nullptr;  // [width] rounding of a row of W, and of the adjoint, times `magnitude`
  const double* bias_error = nullptr;    // [width] rounding of adding the bias
  double remainder_growth = 1.0;         // 1 + the relative rounding of |W| r
  double adjoint_rounding = 0.0;         // relative rounding of a column of W' in the backward sweep
  const double* magnitude_in = nullptr;  // [streams, T] largest size of the model among the inputs
  double* magnitude_out = nullptr;       // [streams, T] the same of the outputs
  double* z = nullptr;                   // [width, streams C, T] models before the activation
  // [width, streams, T] in: |W| r; out: the remainder of z, r and all roundings of the affine map together
  double* z_remainder = nullptr;
  double* a = nullptr;            // [width, streams C, T] models after the activation
  double* a_remainder = nullptr;  // [width, streams, T] their remainders
  double* expansion = nullptr;    // [width, kept_rows, T]
};

// The backward sweep through a layer: sum_k adjoint_k d_k, d_k the deviation of the k-th output from its first-order model
// and adjoint_k an affine function of x - c, is expanded to third order in x - c with what it leaves added to `remainder`,
// and passed on to the layer's inputs. For one derivative at most.
struct PullBackTile {
  const double* adjoint_a =
      nullptr;  // [width, streams, 1 + n, T] of the values after the activation: at c, and slopes
  double* adjoint_z = nullptr;  // [width, streams, 1 + n, T] out: of those before it
  double* hessian = nullptr;    // [n (n + 1) / 2, T] row by row of the upper triangle, added to
  double* cubic = nullptr;      // [n, n (n + 1) / 2, T] of dx_d (dx_e dx_g), e <= g, added to
  double* magnitude = nullptr;  // [T] sum of the sizes of all terms of these, for their rounding
  double* remainder = nullptr;  // [T] added to
  double* scratch = nullptr;    // [2 n, T]
};

// The innermost loops of the proof, compiled once for each instruction set.
struct TaylorKernels {
  // Expands `activation` about z0 [T] for |z - z0| <= radius [T].
  void (*expand)(Activation activation, const double* z0, const double* radius, ActivationExpansion& result);
  // Fills in z_remainder, a, a_remainder, expansion and magnitude_out from the affine map's models z.
  void (*activate)(const LayerTile& layer);
  // Takes the backward sweep through the activation of a layer that `activate` has been through.
  void (*pull_back)(const LayerTile& layer, const PullBackTile& tile);
};

// The kernels for instruction_set().
const TaylorKernels& taylor_kernels();

}  // namespace s2nnds
