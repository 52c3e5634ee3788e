// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/goal_neighbourhood.h"

#include <algorithm>
#include <vector>

namespace s2nnds {
namespace {

constexpr double smallest_cube = 1e-7;

// holds(half) for the T cubes of these half-widths. A tile's worth of cubes costs as much as one of them.
template <typename Holds>
double largest_cube(double largest, const Holds& holds) {
  for (double half = largest; half >= smallest_cube;) {
    TileRow halves;
    for (Eigen::Index lane = 0; lane < tile_boxes; ++lane, half *= 0.5) halves(lane) = half;
    const std::vector<bool> held = holds(halves);
    for (std::size_t lane = 0; lane < held.size(); ++lane) {
      if (held[lane]) return halves(static_cast<Eigen::Index>(lane));
    }
  }
  return 0.0;
}

}  // namespace

double positive_cube(const TaylorFunction& lyapunov, double largest) {
  return largest_cube(largest, [&](const TileRow& halves) {
    std::vector<bool> held;
    for (const IntervalMatrix& gradient : lyapunov.goal_gradient_factors(halves))
      held.push_back(is_positive_definite(gradient));
    return held;
  });
}

double decreasing_cube(const TaylorFunction& field, const TaylorFunction& lyapunov, double largest) {
  return largest_cube(largest, [&](const TileRow& halves) {
    const std::vector<IntervalMatrix> velocity = field.goal_factors(halves),
                                      gradient = lyapunov.goal_gradient_factors(halves);
    std::vector<bool> held;
    for (std::size_t lane = 0; lane < std::min(velocity.size(), gradient.size()); ++lane)
      held.push_back(is_positive_definite(-1.0 * (gradient[lane].transposed() * velocity[lane])));
    return held;
  });
}

}  // namespace s2nnds
