// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/orientation_fit.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/data/orientation.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kDrawn = 8000;   // points of the workspace
constexpr double kLargestShare = 0.97;  // of pi that psi and the initial error may fill at drawn points
constexpr double kFeatureGain = 1.5;    // standard deviation of the features' slopes
constexpr double kTiny = 1e-9;          // weight of the sum of squared weights, for a unique solution
constexpr double kMoreThanShown = 10.0 * M_PI / 180.0;
constexpr double kDurations = 5.0;  // rate times mean duration

// x' x and x' y of a set of points, over their number.
struct Moments {
  Eigen::MatrixXd features;  // [m, m]
  Eigen::MatrixXd targets;   // [m, 3]
};

Layer random_layer(Eigen::Index features, Eigen::Index dimension, std::uint64_t seed) {
  RandomStream random(seed, "orientation");
  Layer layer;
  layer.weight = Points::NullaryExpr(features, dimension, [&] { return kFeatureGain * random.normal(); });
  layer.bias = Vector::NullaryExpr(features, [&] { return random.normal(); });
  layer.activation = Activation::tanh;
  return layer;
}

// The hidden layer's values less those at the goal: [N, m].
Points features_at(const Layer& layer, const Points& z) {
  const auto hidden = [&](const Points& x) {
    const Points a = (x * layer.weight.transpose()).rowwise() + layer.bias.transpose();
    return Points(a.array().tanh());
  };
  return hidden(z).rowwise() - Eigen::RowVectorXd(hidden(Points::Zero(1, z.cols())).row(0));
}

Moments moments(const Points& features, const Points& targets) {
  const auto count = static_cast<double>(features.rows());
  return {features.transpose() * features / count, features.transpose() * targets / count};
}

// Uniform in the workspace, those with B <= 0: [.., n].
Points drawn_safe_points(const NetworkWeights& barrier, const Box& workspace, std::uint64_t seed) {
  RandomStream random(seed, "orientation/points");
  Points drawn(kDrawn, workspace.dimension());
  for (Eigen::Index i = 0; i < drawn.rows(); ++i)
    for (Eigen::Index d = 0; d < drawn.cols(); ++d)
      drawn(i, d) = random.uniform(workspace.lower[d], workspace.upper[d]);
  const Points level = barrier.value(drawn);
  std::vector<Eigen::Index> safe;
  for (Eigen::Index i = 0; i < drawn.rows(); ++i)
    if (level(i, 0) <= 0.0) safe.push_back(i);
  return safe.empty() ? drawn : Points(drawn(safe, Eigen::all));
}

class Fit {
 public:
  Fit(const std::vector<Demonstration>& demonstrations, const Eigen::Vector4d& goal, Layer layer,
      Points drawn)
      : layer_(std::move(layer)), drawn_(std::move(drawn)) {
    for (const Demonstration& d : demonstrations) {
      position_.push_back(d.position);
      target_.push_back(rotation_vectors(goal, d.orientation));
      shown_.push_back(moments(features_at(layer_, d.position), target_.back()));
    }
    const Points features = features_at(layer_, drawn_);
    small_ = moments(features, Points::Zero(features.rows(), 3));
  }

  // Without the demonstration `left_out` (-1: with all).
  NetworkWeights solve(double lambda, std::ptrdiff_t left_out = -1) const {
    const Eigen::Index m = layer_.weight.rows();
    Eigen::MatrixXd a = lambda * small_.features + kTiny * Eigen::MatrixXd::Identity(m, m);
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(m, 3);
    const double share = 1.0 / static_cast<double>(std::ssize(shown_) - (left_out >= 0 ? 1 : 0));
    for (std::ptrdiff_t k = 0; k < std::ssize(shown_); ++k) {
      if (k == left_out) continue;
      a += share * shown_[static_cast<std::size_t>(k)].features;
      b += share * shown_[static_cast<std::size_t>(k)].targets;
    }
    NetworkWeights psi;
    psi.head = Head::zero_at_origin;
    psi.layers = {layer_, Layer{Points(a.ldlt().solve(b).transpose()), {}, Activation::identity}};
    return psi;
  }

  double best_lambda() const {
    if (shown_.size() < 2) return 1e-3;
    double best = 0.0, least = std::numeric_limits<double>::infinity();
    for (int step = 0; step <= kSteps; ++step) {
      double error = 0.0;
      for (std::ptrdiff_t k = 0; k < std::ssize(shown_); ++k)
        error += errors(solve(lambda_of(step), k), static_cast<std::size_t>(k)).squaredNorm() /
                 static_cast<double>(position_[static_cast<std::size_t>(k)].rows());
      if (error < least) {
        least = error;
        best = lambda_of(step);
      }
    }
    return best;
  }

  // |r - psi| along all demonstrations at most, rad.
  double largest_error(const NetworkWeights& psi) const {
    double largest = 0.0;
    for (std::size_t k = 0; k < position_.size(); ++k) largest = std::max(largest, errors(psi, k).maxCoeff());
    return largest;
  }
  // |psi| at the drawn points at most, rad.
  double largest_drawn(const NetworkWeights& psi) const {
    return psi.value(drawn_).rowwise().norm().maxCoeff();
  }

  static double lambda_of(int step) { return std::pow(10.0, -6.0 + 0.5 * step); }
  static constexpr int kSteps = 14;  // to 10

 private:
  Vector errors(const NetworkWeights& psi, std::size_t k) const {
    return (psi.value(position_[k]) - target_[k]).rowwise().norm();
  }

  Layer layer_;
  Points drawn_;
  std::vector<Points> position_, target_;
  std::vector<Moments> shown_;
  Moments small_;
};

double mean_duration(const std::vector<Demonstration>& demonstrations, const Frame& frame) {
  double sum = 0.0;
  for (const Demonstration& d : demonstrations) sum += d.time[d.samples() - 1] - d.time[0];
  return frame.time_scale() * sum / static_cast<double>(demonstrations.size());
}

}  // namespace

void OrientationOptions::visit(FieldVisitor& v) {
  v.field("features", features, between(1, 4096));
  v.field("rate", rate, at_least(0));
  v.field("initial_error", initial_error, {.low = 0, .high = 180, .open_high = true});
}

OrientationLaw fit_orientation(const std::vector<Demonstration>& demonstrations, const Frame& frame,
                               const NetworkWeights& barrier, const Box& workspace,
                               const OrientationOptions& options, std::uint64_t seed) {
  check(!demonstrations.empty() && frame.has_orientation(),
        "orientation: found no demonstrations with orientations, expected at least one");
  const Fit fit(demonstrations, frame.goal_orientation,
                random_layer(options.features, workspace.dimension(), seed),
                drawn_safe_points(barrier, workspace, seed));
  OrientationLaw law;
  law.rate = options.rate > 0.0 ? options.rate : kDurations / mean_duration(demonstrations, frame);
  const double best = fit.best_lambda();
  for (double lambda = best; lambda <= 10.0; lambda *= std::sqrt(10.0)) {
    OrientationLaw next = law;
    next.psi = fit.solve(lambda);
    next.initial_error = options.initial_error > 0.0
                             ? options.initial_error * (M_PI / 180.0)
                             : std::min(fit.largest_error(next.psi) + kMoreThanShown, 0.999 * M_PI);
    const bool fits = fit.largest_drawn(next.psi) + next.initial_error < kLargestShare * M_PI;
    if (lambda == best || fits) law = std::move(next);
    if (fits) break;
  }
  return law;
}

}  // namespace s2nnds
