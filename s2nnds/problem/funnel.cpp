// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/funnel.h"

#include <algorithm>
#include <optional>

namespace s2nnds {
namespace {

constexpr double kSurroundings = 1.5;  // times the distance from the demonstration
constexpr double kSameWay = 0.5;       // least cosine between the directions there
constexpr Eigen::Index kBetween = 10;  // places between a sample and its demonstration that are looked at

constexpr Eigen::Index kShown = 2000;  // samples of all demonstrations that are compared with, about

// Samples of a demonstration, even in length: the slow ones would outnumber the others.
std::vector<Eigen::Index> even_rows(const Demonstration& demonstration, Eigen::Index count) {
  const Points& x = demonstration.position;
  const Vector length = arc_lengths(x);
  std::vector<Eigen::Index> rows;
  Eigen::Index i = 0;
  for (Eigen::Index j = 0; j < count; ++j) {
    const double along = length[x.rows() - 1] * (static_cast<double>(j) + 0.5) / static_cast<double>(count);
    while (i + 1 < x.rows() && length[i] < along) ++i;
    rows.push_back(i);
  }
  return rows;
}

std::vector<Demonstration> thinned(const std::vector<Demonstration>& demonstrations) {
  const Eigen::Index each = std::max<Eigen::Index>(20, kShown / std::ssize(demonstrations));
  std::vector<Demonstration> result;
  for (const Demonstration& whole : demonstrations) {
    const std::vector<Eigen::Index> rows = even_rows(whole, std::min(each, whole.samples()));
    result.push_back({whole.time(rows), whole.position(rows, Eigen::all), whole.velocity(rows, Eigen::all)});
  }
  return result;
}

// What all demonstrations show, and what is made of it.
class Funnel {
 public:
  Funnel(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
         const FunnelOptions& options)
      : problem_(problem),
        options_(options),
        position_(stack_positions(demonstrations)),
        velocity_(stack_velocities(demonstrations)) {}

  // f at x [n]; nothing where that is not clear.
  std::optional<Eigen::RowVectorXd> velocity(const Eigen::RowVectorXd& x) const {
    if (!problem_.workspace.contains(x.transpose())) return std::nullopt;
    const Vector distance = (position_.rowwise() - x).rowwise().norm();
    Eigen::Index nearest = 0;
    const double far = distance.minCoeff(&nearest);
    const Eigen::RowVectorXd shown = velocity_.row(nearest), back = position_.row(nearest) - x;
    const double speed = shown.norm();
    if (!(speed > 0.0) || x.norm() < 2.0 * far) return std::nullopt;
    for (Eigen::Index i = 0; i < distance.size(); ++i) {
      if (distance[i] > kSurroundings * far) continue;
      if (velocity_.row(i).dot(shown) < kSameWay * speed * velocity_.row(i).norm()) return std::nullopt;
    }
    Points between(kBetween + 1, x.size());
    for (Eigen::Index j = 0; j <= kBetween; ++j)
      between.row(j) = x + static_cast<double>(j) / static_cast<double>(kBetween) * back;
    if (problem_.unsafe->level(between).minCoeff() <= 0.0) return std::nullopt;
    const Eigen::RowVectorXd way = shown / speed + options_.steepness * back;
    return speed / way.norm() * way;
  }

 private:
  const SafetyProblem& problem_;
  FunnelOptions options_;
  Points position_, velocity_;
};

// Of the length `distance`, in any direction across the velocity.
Eigen::RowVectorXd across(const Eigen::RowVectorXd& velocity, double distance, RandomStream& random) {
  Eigen::RowVectorXd way(velocity.size());
  for (double& each : way) each = random.normal();
  const double squared_speed = velocity.squaredNorm();
  if (squared_speed > 0.0) way -= way.dot(velocity) / squared_speed * velocity;
  const double length = way.norm();
  return length > 0.0 ? Eigen::RowVectorXd(distance / length * way) : way;
}

}  // namespace

VelocityTargets funnel_samples(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                               std::int64_t count, RandomStream& random, const FunnelOptions& options) {
  std::vector<Eigen::RowVectorXd> places, velocities;
  if (!demonstrations.empty() && count > 0) {
    const Funnel funnel(problem, thinned(demonstrations), options);
    const std::int64_t each = (count + std::ssize(demonstrations) - 1) / std::ssize(demonstrations);
    for (const Demonstration& shown : demonstrations) {
      for (const Eigen::Index row : even_rows(shown, each)) {
        const Eigen::RowVectorXd x =
            shown.position.row(row) +
            across(shown.velocity.row(row), options.reach * random.uniform(), random);
        const auto v = funnel.velocity(x);
        if (!v) continue;
        places.push_back(x);
        velocities.push_back(*v);
      }
    }
  }
  const auto size = std::ssize(places);
  VelocityTargets samples{Points(size, problem.dimension()), Points(size, problem.dimension())};
  for (Eigen::Index i = 0; i < size; ++i) {
    samples.position.row(i) = places[static_cast<std::size_t>(i)];
    samples.velocity.row(i) = velocities[static_cast<std::size_t>(i)];
  }
  return samples;
}

}  // namespace s2nnds
