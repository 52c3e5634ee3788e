// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/survey.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace s2nnds {
namespace {

constexpr double kSixtyDegrees = M_PI / 3;
constexpr double kMostPlaces = 6000;  // of all demonstrations together: they are compared in pairs

// Linear interpolation of the rows of `values` at `count` even places of `along`.
Points evenly(const Vector& along, const Points& values, Eigen::Index count) {
  Points even(count, values.cols());
  Eigen::Index piece = 0;
  const Eigen::Index last = along.size() - 1;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double place = along[last] * static_cast<double>(k) / static_cast<double>(count - 1);
    while (piece + 1 < last && along[piece + 1] < place) ++piece;
    const double width = along[piece + 1] - along[piece];
    const double share = width > 0 ? std::clamp((place - along[piece]) / width, 0.0, 1.0) : 0.0;
    even.row(k) = (1 - share) * values.row(piece) + share * values.row(piece + 1);
  }
  return even;
}

// A demonstration at even steps along its path.
struct Path {
  Points position;   // [P, n]
  Vector time;       // [P] s since its start
  Points direction;  // [P, n], of length 1 or 0
  double step = 0;   // between neighbours
};

Path make_path(const Demonstration& d, Eigen::Index count) {
  const Vector along = arc_lengths(d.position);
  Path path{evenly(along, d.position, count),
            evenly(along, (d.time.array() - d.time[0]).matrix(), count).col(0),
            Points::Zero(count, d.dimension()), along[along.size() - 1] / static_cast<double>(count - 1)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::RowVectorXd chord =
        path.position.row(std::min(i + 1, count - 1)) - path.position.row(std::max<Eigen::Index>(i - 1, 0));
    if (chord.norm() > 0) path.direction.row(i) = chord / chord.norm();
  }
  return path;
}

class CrossingSearch {
 public:
  CrossingSearch(std::vector<Path> paths, double extent, const Eigen::RowVectorXd& goal)
      : paths_(std::move(paths)), extent_(extent), goal_(goal) {}

  std::optional<Crossing> of(std::size_t first, std::size_t second) const {
    const Path &a = paths_[first], &b = paths_[second];
    const double near = std::max({a.step, b.step, 0.005 * extent_});
    std::optional<Crossing> worst;
    for (Eigen::Index i = first == second ? 1 : 0; i + 1 < a.position.rows(); ++i) {
      if ((a.position.row(i) - goal_).norm() < 0.05 * extent_) continue;
      const Eigen::Index j = first == second ? other_branch(a, i, near) : crossed_at(a, i, b, near);
      if (j < 0) continue;
      const double angle = std::acos(std::clamp(a.direction.row(i).dot(b.direction.row(j)), -1.0, 1.0));
      if (first != second && leads_along(a, i, b, j) && leads_along(b, j, a, i)) continue;
      if ((angle > kSixtyDegrees || first == second) && (!worst || angle > worst->angle)) {
        worst = Crossing{
            first, second, a.time[i], b.time[j], 0.5 * (a.position.row(i) + b.position.row(j)).transpose(),
            angle};
      }
    }
    return worst;
  }

 private:
  // The nearest place of `b` where none of its places around goes the way that `a` goes: -1 if there is none.
  // Around a sharp corner, two demonstrations of one motion turn at slightly different places.
  static Eigen::Index crossed_at(const Path& a, Eigen::Index i, const Path& b, double near) {
    Eigen::Index nearest = -1;
    double least = near;
    for (Eigen::Index j = 0; j + 1 < b.position.rows(); ++j) {
      const double distance = (a.position.row(i) - b.position.row(j)).norm();
      if (distance < 4 * near && a.direction.row(i).dot(b.direction.row(j)) > 0.5) return -1;
      if (distance < least) {
        least = distance;
        nearest = j;
      }
    }
    return nearest;
  }
  // Whether `a` is still beside `b` a tenth of the extent after place i, where b is at j. Hands tremble, mostly at the
  // start and the end: where two demonstrations go on together, it does not matter whose direction f takes.
  bool leads_along(const Path& a, Eigen::Index i, const Path& b, Eigen::Index j) const {
    const auto places = [&](const Path& path, double share) {
      return static_cast<Eigen::Index>(std::ceil(share * extent_ / path.step));
    };
    const Eigen::RowVectorXd later = a.position.row(std::min(i + places(a, 0.1), a.position.rows() - 1));
    const Eigen::Index count = std::min(places(b, 0.3), b.position.rows() - j);
    return (b.position.middleRows(j, count).rowwise() - later).rowwise().norm().minCoeff() < 0.05 * extent_;
  }
  // The nearest later place of the same path that it comes to after it was well away.
  static Eigen::Index other_branch(const Path& a, Eigen::Index i, double near) {
    Eigen::Index nearest = -1;
    double least = near;
    bool was_away = false;
    for (Eigen::Index j = i + 1; j + 1 < a.position.rows(); ++j) {
      const double distance = (a.position.row(i) - a.position.row(j)).norm();
      was_away = was_away || distance > 5 * near;
      if (was_away && distance < least) {
        least = distance;
        nearest = j;
      }
    }
    return nearest;
  }

  std::vector<Path> paths_;
  double extent_;
  Eigen::RowVectorXd goal_;
};

double median(Vector values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// The longest stop on the way, if one is long enough. Rest at the start and the end is none.
std::optional<Pause> longest_pause(const Demonstration& d, std::size_t k) {
  const Vector speed = d.velocity.rowwise().norm();
  const double slow = 0.01 * speed.maxCoeff();
  const Eigen::Index last = d.samples() - 1;
  Eigen::Index begin = 0, end = last;
  while (begin < last && speed[begin] <= slow) ++begin;
  while (end > begin && speed[end] <= slow) --end;
  std::optional<Pause> longest;
  for (Eigen::Index i = begin; i <= end; ++i) {
    if (speed[i] > slow) continue;
    Eigen::Index stop = i;
    while (stop < end && speed[stop + 1] <= slow) ++stop;
    const double duration = d.time[stop] - d.time[i];
    if (duration >= 0.1 * (d.time[last] - d.time[0]) && (!longest || duration > longest->duration))
      longest = Pause{k, d.time[i] - d.time[0], duration, d.position.row(i).transpose()};
    i = stop;
  }
  return longest;
}

double spread(const Points& points) {
  return (points.rowwise() - points.colwise().mean()).rowwise().norm().maxCoeff();
}

}  // namespace

Points along_path(const Points& position, Eigen::Index count) {
  return evenly(arc_lengths(position), position, count);
}

Survey survey(const DemonstrationSet& set) {
  check_demonstrations(set, set.name);
  const std::vector<Demonstration>& all = set.demonstrations;
  const auto count = static_cast<Eigen::Index>(all.size());
  const Points positions = stack_positions(all);
  Survey s;
  s.lower = positions.colwise().minCoeff().transpose();
  s.upper = positions.colwise().maxCoeff().transpose();
  s.extent = (s.upper - s.lower).maxCoeff();
  s.duration = s.usual_speed = s.peak_speed = s.closing = Vector(count);
  Points starts(count, set.dimension()), ends(count, set.dimension());
  const auto places =
      static_cast<Eigen::Index>(std::clamp(kMostPlaces / static_cast<double>(count), 20.0, 200.0));
  std::vector<Path> paths;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Demonstration& d = all[static_cast<std::size_t>(k)];
    const Vector speed = d.velocity.rowwise().norm();
    starts.row(k) = d.position.row(0);
    ends.row(k) = d.position.bottomRows(1);
    s.duration[k] = d.time[d.samples() - 1] - d.time[0];
    s.usual_speed[k] = median(speed);
    s.peak_speed[k] = speed.maxCoeff();
    s.closing[k] = (ends.row(k) - starts.row(k)).norm();
    paths.push_back(make_path(d, places));
    if (auto pause = longest_pause(d, static_cast<std::size_t>(k))) s.pauses.push_back(std::move(*pause));
  }
  s.start_spread = spread(starts);
  s.end_spread = spread(ends);
  const CrossingSearch search(std::move(paths), s.extent, ends.colwise().mean());
  for (std::size_t a = 0; a < all.size(); ++a)
    for (std::size_t b = a; b < all.size(); ++b)
      if (auto crossing = search.of(a, b)) s.crossings.push_back(std::move(*crossing));
  return s;
}

}  // namespace s2nnds
