// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/band_sampler.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/verification/network_function.h"
#include "s2nnds/verification/rounding_error.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kEnoughBoxes = 4096;  // a finer cover costs more than it saves
constexpr int kMostHalvings = 40;
constexpr std::int64_t kDrawsPerPoint = 1000;
// Whether a band is too thin by far is judged after so many draws a point, and not before so many draws.
constexpr std::int64_t kLookPerPoint = 10, kFirstLook = 10 * kDrawsPerPoint;
constexpr std::int64_t kLargestBatch = 65536;

// Each box cut in two across the axis: [2 M, n].
Points halve(const Points& lower, Eigen::Index axis, double half_side) {
  Points halves(2 * lower.rows(), lower.cols());
  halves << lower, lower;
  halves.col(axis).tail(lower.rows()).array() += half_side;
  return halves;
}

// The boxes that are not proved to be off the band.
Points near_band(const Points& lower, const Vector& side, double band, ScalarEnclosure& barrier) {
  // Grown by more than the roundings of the corners, so that the boxes leave no gap between them.
  const Vector slack = (lower.cwiseAbs().colwise().maxCoeff().transpose() + side) * 0x1p-48;
  const Points low = lower.rowwise() - slack.transpose();
  const Points high = lower.rowwise() + (side + slack).transpose();
  BoxTile tile(lower.cols());
  Points kept(lower.rows(), lower.cols());
  Eigen::Index count = 0;
  for (Eigen::Index first = 0; first < lower.rows(); first += tile_boxes) {
    const Eigen::Index filled = std::min<Eigen::Index>(tile_boxes, lower.rows() - first);
    tile.assign(low, high, first, filled);
    const TileForm& form = barrier.value(tile);
    const TileRow least = form.lower(tile);
    const TileRow most = form.upper(tile);
    for (Eigen::Index i = 0; i < filled; ++i) {
      const bool off = least[i] > band || most[i] < -band;
      if (!off) kept.row(count++) = lower.row(first + i);
    }
  }
  return kept.topRows(count);
}

}  // namespace

BandSampler::BandSampler(const NetworkWeights& B, const Box& within, double band)
    : barrier_(B),
      quick_barrier_(B),
      band_(band),
      lower_(within.lower.transpose()),
      side_(within.upper - within.lower) {
  check(barrier_.input_dimension() == within.dimension() && within.is_finite() && !within.is_empty(),
        "band sampler: found a box of dimension {}, expected a finite one of dimension {}",
        within.dimension(), barrier_.input_dimension());
  check(band >= 0.0, "band sampler: found band = {}, expected >= 0", band);
  // Twice, since a point may leave the box by its rounding.
  if (!is_sum_of_squares(B.head)) quick_error_ = 2.0 * (float32_error(B, within) + float64_error(B, within));
  const NetworkFunction network(B);
  ScalarEnclosure enclosure(network, nullptr);
  for (int i = 0; i < kMostHalvings && lower_.rows() > 0 && lower_.rows() < kEnoughBoxes; ++i) {
    Eigen::Index axis = 0;
    side_.maxCoeff(&axis);
    side_[axis] *= 0.5;
    lower_ = near_band(halve(lower_, axis, side_[axis]), side_, band, enclosure);
  }
}

double BandSampler::cover_volume() const { return static_cast<double>(lower_.rows()) * side_.prod(); }

Points BandSampler::draw(std::int64_t count, RandomStream& random) const {
  Points x(count, lower_.cols());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto box = static_cast<Eigen::Index>(random.below(static_cast<std::size_t>(lower_.rows())));
    for (Eigen::Index k = 0; k < x.cols(); ++k) x(i, k) = lower_(box, k) + side_[k] * random.uniform();
  }
  return x;
}

Points BandSampler::not_surely_off(const Points& x) const {
  const Points barrier = quick_barrier_.value(x);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const bool off = std::abs(barrier(i, 0)) > band_ + quick_error_ && std::isfinite(barrier(i, 0));
    if (!off) kept.push_back(i);
  }
  return x(kept, Eigen::all);
}

Points BandSampler::sample(std::int64_t count, RandomStream& random) const {
  Points found(count, lower_.cols());
  Eigen::Index rows = 0;
  const std::int64_t batch = std::min(count, kLargestBatch);
  for (std::int64_t draws = 0; rows < count && lower_.rows() > 0; draws += batch) {
    // Twice as thin as it may be. Where the points found lie plays no part in giving up, so that those which
    // are returned after all are i.i.d. nevertheless.
    const bool hopeless =
        draws >= std::max(kLookPerPoint * count, kFirstLook) && 2 * kDrawsPerPoint * rows < draws;
    if (hopeless || draws / kDrawsPerPoint >= count) break;
    const Points x = draw(batch, random);
    const Points near = not_surely_off(x);
    const Points barrier = barrier_.value(near);
    for (Eigen::Index i = 0; i < near.rows() && rows < count; ++i) {
      const bool off = std::abs(barrier(i, 0)) > band_ && std::isfinite(barrier(i, 0));
      if (!off) found.row(rows++) = near.row(i);
    }
  }
  return found.topRows(rows);
}

}  // namespace s2nnds
