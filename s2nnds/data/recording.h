// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// What every reader does with one recording from a file: checks it, keeps every stride-th sample and the last
// one, and differentiates the positions when `velocity` is empty (none recorded). time [M] s,
// position [M, n], velocity [M, n] or [0, 0]. Throws Error starting with `where`.
Demonstration make_demonstration(const Vector& time, const Points& position, const Points& velocity,
                                 std::int64_t stride, const std::string& where);

// Throws Error unless `path` is a file that can be read.
void check_readable(const std::string& path);

// The file's name without folder and ending: "lasa/Sine.mat" -> "Sine".
std::string stem(const std::string& path);

}  // namespace s2nnds
