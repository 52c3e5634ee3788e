// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace s2nnds {

// Unit roundoff of double: one operation is wrong by at most this, relatively.
inline constexpr double unit_roundoff = 0x1p-53;

// A computed sum of at most some 400 non-negative terms, each a product of a few factors, times this is above
// the exact one: 1e-13 is 900 roundings.
inline constexpr double slack = 1.0 + 1e-13;

// Underflow. An operation on doubles is wrong by at most 2^-1022 besides its relative error, even where tiny numbers
// are flushed to zero. What becomes of it on the way to a bound: functions whose growth() is at most `largest_growth`
// = G (taylor_model.h) multiply it by less than G^17 = 1e255. A value or a slope counts as one factor G, an adjoint's slope and
// a Hessian as two, a remainder as three; the longest product has an adjoint's slope, three sizes of what a neuron takes in
// and one of its rate, each at most its remainder, the field's remainder among them. A bound has fewer than 1e9 operations, so
// less than 1e-43 is lost, and at most 1e6 times that where two forms are combined (band_bound.cpp). Functions beyond that
// growth are not examined.
inline constexpr double largest_growth = 1e15;
inline constexpr double underflow = 1e-36;

// The same for the terms of a polynomial, of which there may be thousands.
inline constexpr double polynomial_slack = 1.0 + 1e-12;

}  // namespace s2nnds
