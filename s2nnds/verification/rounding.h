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
// = G (taylor_model.h) multiply it by less than G^12 = 1e180, for a bound is made of at most six factors of each of
// the two functions in it (a value, a slope, a rate, a Hessian, an adjoint, a remainder). A bound has fewer than 1e9
// operations, so less than 1e-118 is lost. Functions beyond that growth are not examined.
inline constexpr double largest_growth = 1e15;
inline constexpr double underflow = 1e-90;

// The same for the terms of a polynomial, of which there may be thousands.
inline constexpr double polynomial_slack = 1.0 + 1e-12;

}  // namespace s2nnds
