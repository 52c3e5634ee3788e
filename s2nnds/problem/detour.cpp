// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/detour.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

constexpr double kStep = 0.02, kFarthest = 1.0;  // by which a path is displaced
constexpr double kRise = 0.3;                    // length of the rise, at least
constexpr double kSteepest = 1.0 / 3.0;          // displacement per length of the rise, at most
constexpr double kTogether = 0.5;      // passages whose middles are nearer than this are led to one side
constexpr int kBisections = 6;         // of a box that may or may not meet the set
constexpr Eigen::Index kLooked = 200;  // samples of a path that are looked at, about
constexpr int kDrawn = 16;             // directions, in more than two dimensions
constexpr int kPassages = 8;           // at most
constexpr double kAside = 0.01;        // samples that are displaced by less are as shown

// Of a demonstration, where it is too near to the unsafe set: samples first to last.
struct Passage {
  std::size_t demonstration;
  Eigen::Index first, last;
};

class Detours {
 public:
  Detours(std::vector<Demonstration>& demonstrations, const SafetyProblem& problem, double clearance)
      : demonstrations_(demonstrations), problem_(problem), clearance_(clearance) {
    for (const Demonstration& each : demonstrations) length_.push_back(arc_lengths(each.position));
  }

  void lead() {
    std::vector<bool> stays(demonstrations_.size(), false);
    for (int k = 0; k < kPassages; ++k) {
      std::vector<Passage> together;
      for (std::size_t d = 0; d < demonstrations_.size(); ++d) {
        if (stays[d]) continue;
        const auto found = passage(d);
        if (found && (together.empty() || (middle(*found) - middle(together.front())).norm() < kTogether))
          together.push_back(*found);
      }
      if (together.empty()) return;
      if (!lead(together))
        for (const Passage& each : together) stays[each.demonstration] = true;
    }
  }

 private:
  const Points& path(const Passage& p) const { return demonstrations_[p.demonstration].position; }
  Eigen::RowVectorXd middle(const Passage& p) const { return path(p).row((p.first + p.last) / 2); }

  bool is_near(const Eigen::RowVectorXd& x) const {
    const Vector reach = Vector::Constant(x.size(), clearance_);
    return may_meet(*problem_.unsafe, {x.transpose() - reach, x.transpose() + reach}, kBisections);
  }

  // The first, where the path can be led aside: neither its start nor its end is near.
  std::optional<Passage> passage(std::size_t d) const {
    const Points& x = demonstrations_[d].position;
    const Vector level = problem_.unsafe->level(x);
    Eigen::Index first = 0;
    while (first < level.size() && level[first] > 0.0) ++first;
    if (first == level.size()) return std::nullopt;
    Eigen::Index last = first;
    while (first > 0 && is_near(x.row(first))) --first;
    while (last + 1 < x.rows() && is_near(x.row(last))) ++last;
    if (first == 0 || last + 1 == x.rows()) return std::nullopt;
    return Passage{d, first, last};
  }

  // Directions across the mean way through, in places.
  std::vector<Eigen::RowVectorXd> directions(const std::vector<Passage>& together) const {
    const Eigen::Index n = problem_.dimension(), places = problem_.places();
    Eigen::RowVectorXd way = Eigen::RowVectorXd::Zero(n);
    for (const Passage& each : together) way += path(each).row(each.last) - path(each).row(each.first);
    way.tail(n - places).setZero();
    way.normalize();
    std::vector<Eigen::RowVectorXd> found;
    RandomStream random(0, "detours");
    for (Eigen::Index k = 0; k < 2 * places + (places > 2 ? kDrawn : 0); ++k) {
      Eigen::RowVectorXd u = Eigen::RowVectorXd::Zero(n);
      if (k < 2 * places) {
        u[k / 2] = k % 2 == 0 ? 1.0 : -1.0;
      } else {
        for (Eigen::Index i = 0; i < places; ++i) u[i] = random.normal();
      }
      u -= u.dot(way) * way;
      if (u.norm() > 0.1) found.push_back(u.normalized());
    }
    return found;
  }

  // The share of the displacement at a sample, and its rate along the path.
  std::pair<double, double> share(const Passage& p, double height, Eigen::Index i) const {
    const Vector& s = length_[p.demonstration];
    const double rise = std::max(kRise, height / kSteepest);
    const double before = std::min(rise, s[p.first]), after = std::min(rise, s[s.size() - 1] - s[p.last]);
    const auto smooth = [](double part, double over) {
      if (!(part < 1.0)) return std::pair(0.0, 0.0);
      const double angle = std::numbers::pi * part;
      return std::pair(0.5 * (1.0 + std::cos(angle)), -0.5 * std::numbers::pi / over * std::sin(angle));
    };
    if (i < p.first) {
      const auto [value, rate] = smooth((s[p.first] - s[i]) / before, before);
      return {value, -rate};
    }
    if (i > p.last) return smooth((s[i] - s[p.last]) / after, after);
    return {1.0, 0.0};
  }

  // The least height that leads the passage past the set, infinite if none does.
  double height(const Passage& p, const Eigen::RowVectorXd& u) const {
    const Points& x = path(p);
    const Eigen::Index every = std::max<Eigen::Index>(1, x.rows() / kLooked);
    const auto clear = [&](double height) {
      for (Eigen::Index i = 0; i < x.rows(); i += every) {
        const double part = share(p, height, i).first;
        if (part == 0.0) continue;
        const Eigen::RowVectorXd moved = x.row(i) + part * height * u;
        if (!problem_.contained.contains(moved.transpose()) || is_near(moved)) return false;
      }
      return true;
    };
    for (double height = kStep; height <= kFarthest; height += kStep)
      if (clear(height)) return height;
    return std::numeric_limits<double>::infinity();
  }

  bool lead(const std::vector<Passage>& together) {
    double least = std::numeric_limits<double>::infinity();
    std::vector<double> chosen;
    Eigen::RowVectorXd side;
    for (const Eigen::RowVectorXd& u : directions(together)) {
      std::vector<double> heights;
      double sum = 0.0;
      for (const Passage& each : together) sum += heights.emplace_back(height(each, u));
      if (!(sum < least)) continue;
      least = sum;
      chosen = heights;
      side = u;
    }
    if (chosen.empty()) return false;
    for (std::size_t k = 0; k < together.size(); ++k) displace(together[k], chosen[k], side);
    return true;
  }

  void displace(const Passage& p, double height, const Eigen::RowVectorXd& u) {
    Demonstration& led = demonstrations_[p.demonstration];
    for (Eigen::Index i = 0; i < led.samples(); ++i) {
      const auto [part, rate] = share(p, height, i);
      led.position.row(i) += part * height * u;
      led.velocity.row(i) += rate * height * led.velocity.row(i).norm() * u;
    }
    length_[p.demonstration] = arc_lengths(led.position);
  }

  std::vector<Demonstration>& demonstrations_;
  const SafetyProblem& problem_;
  double clearance_;
  std::vector<Vector> length_;  // along each path
};

}  // namespace

VelocityTargets detour_samples(const SafetyProblem& problem, const std::vector<Demonstration>& demonstrations,
                               double clearance) {
  const Points shown = stack_positions(demonstrations);
  std::vector<Demonstration> led = demonstrations;
  Detours(led, problem, clearance).lead();
  const Points position = stack_positions(led), velocity = stack_velocities(led);
  std::vector<Eigen::Index> aside;
  for (Eigen::Index i = 0; i < shown.rows(); ++i)
    if ((position.row(i) - shown.row(i)).norm() > kAside) aside.push_back(i);
  return {position(aside, Eigen::all), velocity(aside, Eigen::all)};
}

}  // namespace s2nnds
