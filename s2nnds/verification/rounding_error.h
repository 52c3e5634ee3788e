// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/networks/network_weights.h"
#include "s2nnds/problem/box.h"

namespace s2nnds {

// Bounds on |computed y(x) - y(x)|_2 over the box, in float32 and in double: every product and sum of the layers rounded
// in any order, fused or not; weights, biases and x rounded to the format first, up to two more roundings of x and y
// (scales), and activations wrong by at most 8 units in the last place (of 1, for bounded ones). The offset N(0) of a
// zero_at_origin network counts twice. Rigorous for values below 1e30, with gradual underflow. They throw Error for
// sums of squares and for a box that is unbounded or of another dimension.
double float32_error(const NetworkWeights& network, const Box& box);
double float64_error(const NetworkWeights& network, const Box& box);

// float32_error over one box, which is not computed again while the network stays as it is.
class Float32Error {
 public:
  double of(const NetworkWeights& network, const Box& box);

 private:
  std::string network_;  // hash of the last one
  double error_ = 0.0;
};

}  // namespace s2nnds
