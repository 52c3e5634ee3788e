// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/start_paths.h"

#include <algorithm>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

constexpr double kNear = 0.03;   // a start nearer than this to one that was shown needs no path of its own
constexpr double kShown = 0.01;  // a displacement less than this needs no samples
constexpr std::int64_t kDrawn = 16;

// The demonstration displaced by `way` [n] at its start, as far as that differs from it.
Demonstration displaced(const Demonstration& shown, const Eigen::RowVectorXd& way, std::int64_t samples) {
  const Vector factor = displacement_along(shown.position);
  const Eigen::Index all = shown.samples();
  Eigen::Index differing = 0;
  while (differing < all && factor[differing] * way.norm() >= kShown) ++differing;
  const Eigen::Index count = std::min<Eigen::Index>(differing, samples);
  Demonstration path{Vector(count), Points(count, way.size()), Points(count, way.size())};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index k = i * differing / count, before = std::max<Eigen::Index>(k - 1, 0),
                       after = std::min(k + 1, all - 1);
    const double duration = shown.time[after] - shown.time[before];
    path.time[i] = shown.time[k];
    path.position.row(i) = shown.position.row(k) + factor[k] * way;
    path.velocity.row(i) = shown.velocity.row(k) + (factor[after] - factor[before]) / duration * way;
  }
  return path;
}

}  // namespace

std::size_t nearest_start(const std::vector<Demonstration>& demonstrations, const Vector& start) {
  check(!demonstrations.empty(), "start paths: found no demonstrations, expected at least one");
  const auto distance = [&](const Demonstration& each) {
    return (each.position.row(0).transpose() - start).norm();
  };
  const auto nearest =
      std::min_element(demonstrations.begin(), demonstrations.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return static_cast<std::size_t>(nearest - demonstrations.begin());
}

Vector displacement_along(const Points& path) {
  Vector left = Vector::Zero(path.rows());  // length from here to the end
  for (Eigen::Index i = path.rows() - 2; i >= 0; --i)
    left[i] = left[i + 1] + (path.row(i + 1) - path.row(i)).norm();
  if (!(left[0] > 0.0)) return Vector::Zero(path.rows());
  return (left / left[0]).array().square();
}

std::vector<Demonstration> start_paths(const std::vector<Demonstration>& demonstrations, const Points& starts,
                                       std::int64_t samples) {
  check(samples >= 2, "start paths: found {} samples, expected at least 2", samples);
  std::vector<Demonstration> paths;
  for (Eigen::Index i = 0; i < starts.rows(); ++i) {
    const Demonstration& shown = demonstrations[nearest_start(demonstrations, starts.row(i).transpose())];
    const Eigen::RowVectorXd way = starts.row(i) - shown.position.row(0);
    if (way.norm() < kNear) continue;
    if (Demonstration path = displaced(shown, way, samples); path.samples() >= 2)
      paths.push_back(std::move(path));
  }
  return paths;
}

Points spread_starts(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                     std::int64_t count, RandomStream& random) {
  const Points none(0, problem.dimension());
  const auto sampler = sampler_of(problem.initial, problem.workspace);
  if (!sampler || count <= 0) return none;
  const Points drawn = sampler->sample(static_cast<std::size_t>(kDrawn * count), random);
  Vector distance = Vector::Constant(drawn.rows(), std::numeric_limits<double>::infinity());
  const auto cover = [&](const Eigen::RowVectorXd& place) {
    distance = distance.cwiseMin((drawn.rowwise() - place).rowwise().norm());
  };
  for (const Demonstration& each : demonstrations) cover(each.position.row(0));
  Points starts(count, drawn.cols());
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::Index farthest = 0;
    distance.maxCoeff(&farthest);
    starts.row(i) = drawn.row(farthest);
    cover(starts.row(i));
  }
  return starts;
}

}  // namespace s2nnds
