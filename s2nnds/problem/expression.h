// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/problem/expression_tree.h"

namespace s2nnds {

// Reads a closed form in n = `dimension` variables, such as "max(y, -4*x - 0.8*y - 1.6, 4*x - 0.8*y + 0.8)":
// - numbers, and the constant pi;
// - the variables x, y, z or x1 ... xn, also xi1 ... xin and xi(1) ... xi(n);
// - the signs + - * /, and powers as ** or ^, which bind tighter than a minus sign: -x^2 = -(x^2);
// - max and min of two or more, sin, cos, tan, exp, log, sqrt, abs, tanh.
// A power whose exponent is not a whole number needs a base >= 0. Throws Error with the text and what is
// wrong with it.
ExpressionTree parse_expression(const std::string& text, Eigen::Index dimension);

}  // namespace s2nnds
