// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/demonstration.h"

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

Points stack(const std::vector<Demonstration>& demonstrations, Points Demonstration::*part) {
  if (demonstrations.empty()) return {};
  Eigen::Index rows = 0;
  for (const Demonstration& d : demonstrations) rows += (d.*part).rows();
  const Eigen::Index columns = (demonstrations.front().*part).cols();
  Points all(rows, columns);
  Eigen::Index row = 0;
  for (const Demonstration& d : demonstrations) {
    const Points& points = d.*part;
    check(points.cols() == columns, "demonstrations: found dimensions {} and {}; expected one dimension",
          columns, points.cols());
    all.middleRows(row, points.rows()) = points;
    row += points.rows();
  }
  return all;
}

}  // namespace

Eigen::Index DemonstrationSet::dimension() const {
  check(!demonstrations.empty(), "{}: found no demonstrations; expected at least 1", name);
  return demonstrations.front().dimension();
}

void check_demonstration(const Demonstration& d, const std::string& where) {
  check(d.dimension() >= 2, "{}: found dimension {}; expected at least 2", where, d.dimension());
  check(d.samples() >= 2, "{}: found {} sample(s); expected at least 2", where, d.samples());
  check(d.time.size() == d.samples(), "{}: found {} times for {} positions; expected one each", where,
        d.time.size(), d.samples());
  check(d.velocity.rows() == d.samples() && d.velocity.cols() == d.dimension(),
        "{}: found velocities [{}, {}]; expected [{}, {}] as the positions", where, d.velocity.rows(),
        d.velocity.cols(), d.samples(), d.dimension());
  check(d.time.allFinite(), "{}: found a time that is NaN or infinite; expected finite numbers", where);
  check(d.position.allFinite(), "{}: found a position that is NaN or infinite; expected finite numbers",
        where);
  check(d.velocity.allFinite(), "{}: found a velocity that is NaN or infinite; expected finite numbers",
        where);
  check(d.orientation.size() == 0 || (d.orientation.rows() == d.samples() && d.orientation.cols() == 4),
        "{}: found orientations [{}, {}]; expected [{}, 4]", where, d.orientation.rows(),
        d.orientation.cols(), d.samples());
  check(d.orientation.size() == 0 ||
            ((d.orientation.rowwise().norm().array() - 1.0).abs() <= 1e-6).all(),  // false for NaN
        "{}: found an orientation that is no unit quaternion", where);
  for (Eigen::Index i = 1; i < d.samples(); ++i) {
    check(d.time[i] > d.time[i - 1], "{}: found time {} at sample {} after {}; expected increasing times",
          where, d.time[i], i, d.time[i - 1]);
  }
}

void check_demonstrations(const DemonstrationSet& set, const std::string& source) {
  check(!set.demonstrations.empty(), "{}: found no demonstrations; expected at least 1", source);
  for (std::size_t k = 0; k < set.demonstrations.size(); ++k) {
    const Demonstration& d = set.demonstrations[k];
    check_demonstration(d, fmt::format("{}: demonstration {}", source, k));
    check(d.dimension() == set.dimension(),
          "{}: demonstration {}: found dimension {}; expected {} as the first", source, k, d.dimension(),
          set.dimension());
    check((d.orientation.size() > 0) == (set.demonstrations.front().orientation.size() > 0),
          "{}: demonstration {}: found orientations in some demonstrations; expected them in all or none",
          source, k);
  }
}

Vector arc_lengths(const Points& path) {
  Vector along = Vector::Zero(path.rows());
  for (Eigen::Index i = 1; i < path.rows(); ++i)
    along[i] = along[i - 1] + (path.row(i) - path.row(i - 1)).norm();
  return along;
}

Points stack_positions(const std::vector<Demonstration>& demonstrations) {
  return stack(demonstrations, &Demonstration::position);
}

Points stack_velocities(const std::vector<Demonstration>& demonstrations) {
  return stack(demonstrations, &Demonstration::velocity);
}

}  // namespace s2nnds
