// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/problem/safety_problem.h"

namespace s2nnds {

// Two demonstrations that start together and pass the obstacle on different sides.
struct PassingSides {
  std::size_t first, second;
  Vector place;  // [n] a point of the obstacle that lies between them, normalised
};

// In two dimensions: the first pair of demonstrations (normalised) that start within `near` of each other and go round
// some point of the obstacle, the one forth and the other back. A motion x' = f(x) from there can take one way
// only. 200 points of the obstacle are looked at. Nothing in other dimensions, where paths can be moved across.
std::optional<PassingSides> find_passing_sides(const SafetyProblem& problem,
                                               const std::vector<Demonstration>& demonstrations,
                                               double near = 0.1);

}  // namespace s2nnds
