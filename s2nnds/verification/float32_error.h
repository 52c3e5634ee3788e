// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/network_weights.h"
#include "s2nnds/problem/box.h"

namespace s2nnds {

// A bound on |y_float32(x) - y(x)|_2 over the box: every product and sum of the layers rounded to 24 bits in
// any order, weights, biases and x rounded to float32 first, up to two more roundings of x and y (scales),
// and activations wrong by at most 8 units in the last place (of 1, for bounded ones). The offset N(0) of a
// zero_at_origin network counts twice. Rigorous for values below 1e30, with gradual underflow. Throws Error
// for the head squared_norm and for a box that is unbounded or of another dimension.
double float32_error(const NetworkWeights& network, const Box& box);

}  // namespace s2nnds
