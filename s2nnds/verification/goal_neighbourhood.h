// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/verification/taylor_model.h"

namespace s2nnds {

// Boxes cannot prove V > 0 and Vdot < 0 next to the goal, where both vanish. There f(x) = A x and
// grad V(x) = G x, with A and G in interval matrices over the cube |x|_inf <= half, so V = x' S x with 2 S in
// G, and Vdot = x' G' A x.
// The largest half-width, of `largest` and its halves down to some 1e-8, with V(x) > 0 for all x != 0 of the cube;
// 0 if none is found.
double positive_cube(const TaylorFunction& lyapunov, double largest);
// The same for grad V . f < 0.
double decreasing_cube(const TaylorFunction& field, const TaylorFunction& lyapunov, double largest);

}  // namespace s2nnds
