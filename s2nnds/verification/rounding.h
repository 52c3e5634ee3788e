// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace s2nnds {

// Unit roundoff of double: one operation is wrong by at most this, relatively.
inline constexpr double unit_roundoff = 0x1p-53;

// A computed sum of at most some 400 non-negative terms, each a product of a few factors, times this is above
// the exact one: 1e-13 is 900 roundings.
inline constexpr double slack = 1.0 + 1e-13;

// The same for the terms of a polynomial, of which there may be thousands.
inline constexpr double polynomial_slack = 1.0 + 1e-12;

}  // namespace s2nnds
