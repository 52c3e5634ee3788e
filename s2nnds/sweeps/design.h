// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/sweeps/axis.h"
#include "s2nnds/sweeps/sweep_options.h"

namespace s2nnds {

// One value, as TOML text, for each axis.
using DesignPoint = std::vector<std::string>;

// grid: every combination, the last axis running fastest. random: `points` independent draws. sobol: the
// first `points` of Sobol's sequence (from (1/2, 1/2, ...) on), each coordinate XORed with a number of its
// own unless design_seed is 0, which keeps the sequence's even spread. The same options give the same points.
// list: one empty point a trial. Without axes: one point.
std::vector<DesignPoint> make_design(const SweepOptions& options, const std::vector<Axis>& axes);

// For each of `points` one of `pairs`: all of them in turn, each time through in another random order, so
// that they meet every value of every axis alike. More points keep the old ones' pairs.
std::vector<std::int64_t> pairs_in_turn(std::size_t points, std::size_t pairs, std::uint64_t design_seed);

}  // namespace s2nnds
