// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// A number that is at least the spectral norm of the matrix, in exact arithmetic: the 512th root of the trace of the
// 256th power of its Gram matrix, computed in intervals. Above it by 0.9 % at most for 64 rows or columns. Infinite
// where an interval overflows.
double spectral_norm_bound(const Points& matrix);

// A number that is at least the Lipschitz constant (Euclidean norms) of the layers' output N on R^n: the product of the
// bounds above and of the activations' largest slopes.
double lipschitz_bound(const NetworkWeights& network);

}  // namespace s2nnds
