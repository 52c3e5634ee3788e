// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/band_bound.h"

#include <cmath>

#include "s2nnds/verification/rounding.h"

namespace s2nnds {
namespace {

// Multipliers beyond this would magnify what underflow leaves more than `underflow` has room for.
constexpr double kLargestMultiplier = 1e6;

// The l, at least `least_multiplier`, for which the linear part of q - l level + |l| band is the least on the box. That is a
// convex function of l with kinks where a slope vanishes, so it is least at one of them or at 0. Rounded; any l gives a bound.
double multiplier(const TileForm& q, const TileForm& level, double band, double least_multiplier,
                  const BoxTile& tile, Eigen::Index lane) {
  const Eigen::Index n = tile.dimension();
  const auto excess = [&](double l) {
    double sum = std::abs(l) * band - l * level.value(lane);
    for (Eigen::Index d = 0; d < n; ++d)
      sum += std::abs(q.gradient[d](lane) - l * level.gradient[d](lane)) * tile.half[d](lane);
    return sum;
  };
  double best = 0.0, least = excess(0.0);
  for (Eigen::Index d = 0; d < n; ++d) {
    const double l = q.gradient[d](lane) / level.gradient[d](lane);
    if (!(std::abs(l) <= kLargestMultiplier) || l < least_multiplier) continue;
    if (const double sum = excess(l); sum < least) {
      best = l;
      least = sum;
    }
  }
  return best;
}

// Above the sum of the |terms| of the polynomial, and of those that went into it.
TileRow size(const TileForm& form, const BoxTile& tile) {
  TileRow sum = form.magnitude + form.value.abs();
  std::size_t at = 0;
  for (Eigen::Index d = 0; d < tile.dimension(); ++d) {
    sum += form.gradient[d].abs() * tile.half[d];
    for (Eigen::Index e = d; e < tile.dimension(); ++e, ++at)
      sum += form.hessian[at].abs() * tile.half[d] * tile.half[e];
  }
  const Eigen::Index n = tile.dimension();
  at = 0;
  for (Eigen::Index d = 0; d < n; ++d) {
    for (Eigen::Index e = 0; e < n; ++e) {
      for (Eigen::Index g = e; g < n; ++g, ++at)
        sum += form.cubic[at].abs() * tile.half[d] * tile.half[e] * tile.half[g];
    }
  }
  return sum * slack;
}

// Above q - l level + |l| band.
TileRow upper_of_difference(const TileForm& q, const TileRow& l, const TileForm& level, double band,
                            const BoxTile& tile) {
  TileForm reduced = q;
  reduced.value -= l * level.value;
  for (std::size_t d = 0; d < q.gradient.size(); ++d) reduced.gradient[d] -= l * level.gradient[d];
  for (std::size_t at = 0; at < q.hessian.size(); ++at) reduced.hessian[at] -= l * level.hessian[at];
  for (std::size_t at = 0; at < q.cubic.size(); ++at) reduced.cubic[at] -= l * level.cubic[at];
  reduced.remainder = (q.remainder + l.abs() * (level.remainder + band)) * slack;
  // What cancelled was rounded before.
  reduced.magnitude = (size(q, tile) + l.abs() * size(level, tile)) * slack;
  reduced.operations += level.operations;
  return reduced.upper(tile);
}

}  // namespace

TileRow upper_within(const TileForm& q, const TileForm& level, double band, const BoxTile& tile) {
  TileRow l;
  for (Eigen::Index lane = 0; lane < tile_boxes; ++lane)
    l(lane) = multiplier(q, level, band, -kLargestMultiplier, tile, lane);
  return upper_of_difference(q, l, level, band, tile);
}

TileRow upper_below(const TileForm& q, const TileForm& level, const BoxTile& tile) {
  TileRow l;
  for (Eigen::Index lane = 0; lane < tile_boxes; ++lane) l(lane) = multiplier(q, level, 0.0, 0.0, tile, lane);
  return upper_of_difference(q, l, level, 0.0, tile);
}

}  // namespace s2nnds
