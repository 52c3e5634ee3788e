// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/core/points.h"

namespace s2nnds {

// The points [N, n] in a file's bytes, n = `dimension`; `name`, by whose ending the format is known, stands in
// messages. Text (.csv, .txt, .xyz): a point a line, numbers between commas, semicolons or blanks, with a
// header that names x, y, z (or x1 to xn), or without one and with n columns. PLY (text or binary), PCD (text or
// binary; points without coordinates, as of rays that met nothing, are left out) and NPY (numbers, [N, n]). In
// the plane, a file in space is taken if all its points have one height. Throws Error where the file is not
// whole or has another format, no points or a coordinate that is not finite.
Points read_point_cloud(const std::string& bytes, const std::string& name, Eigen::Index dimension);

}  // namespace s2nnds
