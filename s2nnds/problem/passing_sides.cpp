// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/passing_sides.h"

#include <cmath>

#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

// The angle by which the path [M, 2] turns around a point, radians.
double turning(const Points& path, const Eigen::RowVector2d& about) {
  double sum = 0.0;
  for (Eigen::Index i = 1; i < path.rows(); ++i) {
    const Eigen::RowVector2d a = path.row(i - 1) - about, b = path.row(i) - about;
    sum += std::atan2(a[0] * b[1] - a[1] * b[0], a.dot(b));
  }
  return sum;
}

// The angle from a to b seen from a point, on the short way.
double angle_between(const Eigen::RowVector2d& a, const Eigen::RowVector2d& b,
                     const Eigen::RowVector2d& about) {
  Points two(2, 2);
  two << a, b;
  return turning(two, about);
}

}  // namespace

std::optional<PassingSides> find_passing_sides(const SafetyProblem& problem,
                                               const std::vector<Demonstration>& demonstrations,
                                               double near) {
  if (problem.places() != 2) return std::nullopt;
  const auto sampler = sampler_of(problem.unsafe, problem.workspace);
  if (!sampler) return std::nullopt;
  RandomStream random(0, "passing sides");
  const Points obstacle = sampler->sample(200, random).leftCols(2);
  for (std::size_t a = 0; a < demonstrations.size(); ++a) {
    for (std::size_t b = a + 1; b < demonstrations.size(); ++b) {
      const Points first = demonstrations[a].position.leftCols(2),
                   second = demonstrations[b].position.leftCols(2);
      if ((first.row(0) - second.row(0)).norm() > near) continue;
      for (Eigen::Index k = 0; k < obstacle.rows(); ++k) {
        const Eigen::RowVector2d about = obstacle.row(k);
        const double loop = turning(first, about) +
                            angle_between(first.bottomRows(1).row(0), second.bottomRows(1).row(0), about) -
                            turning(second, about) + angle_between(second.row(0), first.row(0), about);
        if (std::abs(loop) > M_PI) return PassingSides{a, b, obstacle.row(k).transpose()};
      }
    }
  }
  return std::nullopt;
}

}  // namespace s2nnds
