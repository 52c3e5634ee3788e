// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/phase_regression.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/dynamic_time_warping.h"

namespace s2nnds {
namespace {

// Chosen by left-out demonstrations of LASA motions that no table has.
constexpr double kWidth = 0.015;  // of a component in phase, standard deviation
constexpr double kFloor = 0.02;   // standard deviation that is added to a component's positions
constexpr double kSlope = 0.5;    // factor of the slopes: a handful of demonstrations overestimate them

constexpr Eigen::Index kPhases = 63;
constexpr Eigen::Index kSamples = 125;  // of a demonstration at most: its samples lie close together
constexpr int kAlignments = 3;
constexpr double kMeanWidth = 0.01;  // in phase, of the mean motion's kernel
// Of squared velocities beside squared positions in the warping's cost.
constexpr double kVelocityWeight = 0.1;
constexpr Eigen::Index kReach = 3;  // samples to either side over which a warped phase is averaged

// The samples of one demonstration.
struct Motion {
  Points state;  // [M, 2n] position, velocity
  Vector phase;  // [M] not decreasing
};

Motion thinned(const Demonstration& whole) {
  const Eigen::Index stride = (whole.samples() + kSamples - 1) / kSamples;
  const auto rows = Eigen::seqN(0, (whole.samples() + stride - 1) / stride, stride);
  Motion motion;
  motion.state.resize(rows.size(), 2 * whole.dimension());
  motion.state << whole.position(rows, Eigen::all), whole.velocity(rows, Eigen::all);
  motion.phase = Vector::LinSpaced(rows.size(), 0.0, 1.0);
  return motion;
}

double phase(Eigen::Index k) { return static_cast<double>(k) / static_cast<double>(kPhases - 1); }

Vector weights(const Motion& motion, double at, double width) {
  return (-0.5 * ((motion.phase.array() - at) / width).square()).exp();
}

// The mean over the motions at each phase, [kPhases, 2n].
Points mean_motion(const std::vector<Motion>& motions) {
  Points mean = Points::Zero(kPhases, motions.front().state.cols());
  for (const Motion& motion : motions) {
    for (Eigen::Index k = 0; k < kPhases; ++k) {
      // Where no sample is near, all count alike.
      const Vector w = weights(motion, phase(k), kMeanWidth).array() + 1e-300;
      mean.row(k) += w.transpose() * motion.state / w.sum();
    }
  }
  return mean / static_cast<double>(motions.size());
}

// What it costs to match a sample with a phase of the mean motion, [M, kPhases].
Points matching_cost(const Points& state, const Points& mean) {
  const Eigen::Index n = state.cols() / 2;
  Points cost(state.rows(), kPhases);
  for (Eigen::Index k = 0; k < kPhases; ++k) {
    const Points difference = state.rowwise() - mean.row(k);
    cost.col(k) = difference.leftCols(n).rowwise().squaredNorm() +
                  kVelocityWeight * difference.rightCols(n).rowwise().squaredNorm();
  }
  return cost;
}

// For each sample the mean of the phases that it is matched with, [M].
Vector warped_phase(const Points& cost) {
  Vector sum = Vector::Zero(cost.rows()), count = sum;
  for (const auto& [sample, k] : warp(cost).pairs) {
    sum[sample] += phase(k);
    count[sample] += 1.0;
  }
  return sum.cwiseQuotient(count);
}

// A moving average: samples that were matched with one phase get phases of their own.
Vector averaged(const Vector& phases) {
  Vector result = Vector::Zero(phases.size());
  for (Eigen::Index i = 0; i < phases.size(); ++i) {
    for (Eigen::Index j = i - kReach; j <= i + kReach; ++j)
      result[i] += phases[std::clamp<Eigen::Index>(j, 0, phases.size() - 1)] / (2 * kReach + 1);
  }
  return result;
}

std::vector<Motion> aligned(const std::vector<Demonstration>& demonstrations) {
  std::vector<Motion> motions;
  for (const Demonstration& each : demonstrations) motions.push_back(thinned(each));
  for (int i = 0; i < kAlignments; ++i) {
    const Points mean = mean_motion(motions);
    for (Motion& motion : motions) motion.phase = averaged(warped_phase(matching_cost(motion.state, mean)));
  }
  return motions;
}

// Mean and covariance of all motions' samples about one phase.
struct Moments {
  double weight = 0.0;
  Vector mean;
  Eigen::MatrixXd covariance;
};

Moments moments(const std::vector<Motion>& motions, double at) {
  const Eigen::Index size = motions.front().state.cols();
  Moments all{0.0, Vector::Zero(size), Eigen::MatrixXd::Zero(size, size)};
  for (const Motion& motion : motions) {
    const Vector w = weights(motion, at, kWidth);
    all.weight += w.sum();
    all.mean += motion.state.transpose() * w;
  }
  all.mean /= all.weight;
  for (const Motion& motion : motions) {
    const Points difference = motion.state.rowwise() - all.mean.transpose();
    all.covariance +=
        difference.transpose() * weights(motion, at, kWidth).asDiagonal() * difference / all.weight;
  }
  return all;
}

}  // namespace

PhaseRegression::PhaseRegression(const std::vector<Demonstration>& demonstrations) {
  check(demonstrations.size() >= 2, "phase regression: found {} demonstrations, expected at least 2",
        demonstrations.size());
  const std::vector<Motion> motions = aligned(demonstrations);
  const Eigen::Index n = demonstrations.front().dimension();
  for (Eigen::Index k = 0; k < kPhases; ++k) {
    const Moments all = moments(motions, phase(k));
    if (!(all.weight > 1e-6)) continue;  // no demonstration has samples there
    Eigen::MatrixXd position = all.covariance.topLeftCorner(n, n);
    position.diagonal().array() += kFloor * kFloor;
    const Eigen::LLT<Eigen::MatrixXd> factor(position);
    const Eigen::MatrixXd whitening = factor.matrixL().solve(Eigen::MatrixXd::Identity(n, n));
    components_.push_back({all.mean.head(n), all.mean.tail(n),
                           kSlope * factor.solve(all.covariance.topRightCorner(n, n)).transpose(), whitening,
                           whitening.diagonal().array().log().sum(),
                           std::sqrt(all.covariance.topLeftCorner(n, n).trace())});
  }
}

Points PhaseRegression::responsibilities(const Points& x) const {
  const auto count = static_cast<Eigen::Index>(components_.size());
  Points exponent(x.rows(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Component& c = components_[static_cast<std::size_t>(k)];
    const Points whitened = (x.rowwise() - c.position.transpose()) * c.whitening.transpose();
    exponent.col(k) = c.log_scale - 0.5 * whitened.rowwise().squaredNorm().array();
  }
  // Relative to the likeliest phase, since far away all densities underflow.
  exponent.colwise() -= exponent.rowwise().maxCoeff().eval();
  const Points weight = exponent.array().exp();
  return weight.array().colwise() / weight.rowwise().sum().array();
}

Points PhaseRegression::velocity(const Points& x) const {
  const Points weight = responsibilities(x);
  Points sum = Points::Zero(x.rows(), x.cols());
  for (Eigen::Index k = 0; k < weight.cols(); ++k) {
    const Component& c = components_[static_cast<std::size_t>(k)];
    Points at_phase = (x.rowwise() - c.position.transpose()) * c.slope.transpose();
    at_phase.rowwise() += c.velocity.transpose();
    sum.array() += at_phase.array().colwise() * weight.col(k).array();
  }
  return sum;
}

Vector PhaseRegression::spread(const Points& x) const {
  Vector each(std::ssize(components_));
  for (Eigen::Index k = 0; k < each.size(); ++k) each[k] = components_[static_cast<std::size_t>(k)].spread;
  return responsibilities(x) * each;
}

}  // namespace s2nnds
