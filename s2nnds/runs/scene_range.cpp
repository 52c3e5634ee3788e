// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/scene_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/enclosing_ball.h"
#include "s2nnds/problem/framed_region.h"
#include "s2nnds/problem/placed_region.h"
#include "s2nnds/runs/statement.h"
#include "s2nnds/runs/user_units.h"

namespace s2nnds {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMostStretch = 0.95;
// A range below this share of the obstacle's own ball is no range.
constexpr double kLeastShare = 1e-3;

bool holds_whatever_the_phase(const RegionOptions& region) {
  return region.type == "extrusion" && region.inflate == 0.0 && region.from == -kInfinity &&
         region.to == kInfinity && region.of.size() == 1;
}

// The parts of a union, each grown as the union is; what makes them is make_region().
std::vector<RegionOptions> parts_of(const RegionOptions& region) {
  std::vector<RegionOptions> parts;
  if (holds_whatever_the_phase(region)) {
    for (RegionOptions& part : parts_of(region.of.front()))
      parts.push_back({.type = "extrusion", .of = {std::move(part)}});
    return parts;
  }
  if (region.type != "union") return {region};
  for (RegionOptions part : region.of) {
    part.inflate += region.inflate;
    for (RegionOptions& inner : parts_of(part)) parts.push_back(std::move(inner));
  }
  return parts;
}

bool has_arm(const RegionOptions& region) {
  return region.type == "arm" || std::any_of(region.of.begin(), region.of.end(), has_arm);
}

// The obstacles, normalised: those that are displaced, as one, and the others.
struct Obstacles {
  RegionPtr moving;
  std::vector<RegionPtr> fixed;
};

Obstacles split(const PreparedRun& setup, const std::optional<std::int64_t>& chosen) {
  const SafetyProblem& problem = setup.problem;
  check(problem.written_unsafe.type != "none",
        "range: found no obstacle, expected one that can be displaced");
  check(!has_arm(problem.written_unsafe),
        "range: found an obstacle for the links of an arm, expected one among the places of the state: "
        "displaced joint angles "
        "are no displaced obstacle");
  const std::vector<RegionOptions> parts = parts_of(problem.written_unsafe);
  // What a tool sweeps is a union of copies of all obstacles, one after the other, and each obstacle's copies move as one.
  const std::int64_t count = std::ssize(parts_of(setup.config.problem.unsafe));
  check(!chosen || (*chosen >= 0 && *chosen < count), "range: found --obstacle {}, expected one of 0 to {}",
        chosen.value_or(0), count - 1);
  Obstacles found;
  if (!chosen || count == 1) {
    found.moving = problem.unsafe;
    return found;
  }
  RegionFiles files = setup.files;
  std::vector<RegionPtr> moving;
  for (std::int64_t k = 0; k < std::ssize(parts); ++k) {
    RegionPtr region =
        make_region(parts[static_cast<std::size_t>(k)], problem.dimension(), files, "problem.unsafe");
    if (setup.config.problem.frame == "data")
      region = framed(std::move(region), setup.data.frame.goal, setup.data.frame.position_scale);
    (k % count == *chosen ? moving : found.fixed).push_back(std::move(region));
  }
  found.moving = moving.size() == 1 ? moving.front() : unite(std::move(moving));
  return found;
}

// The box with sides of twice the length around the same middle; of a phase as it is.
Box doubled(const Box& box, Eigen::Index places) {
  Box result = box;
  const Vector half = box.half_widths();
  result.lower.head(places) -= half.head(places);
  result.upper.head(places) += half.head(places);
  return result;
}

// From the center to where the part of the workspace ends that the safe set must lie in.
double distance_to_sides(const Box& box, const Vector& center) {
  double least = kInfinity;
  for (Eigen::Index i = 0; i < center.size(); ++i) {
    least = std::min(
        {least, (Interval(center[i]) - box.lower[i]).lower, (Interval(box.upper[i]) - center[i]).lower});
  }
  return least;
}

double norm_below(const Vector& x) {
  Interval sum = 0.0;
  for (const double each : x) sum += square(Interval(each));
  return sqrt(sum).lower;
}
double norm_above(const Vector& x) {
  Interval sum = 0.0;
  for (const double each : x) sum += square(Interval(each));
  return sqrt(sum).upper;
}

struct Limit {
  double distance = kInfinity;  // from the ball's center, rounded down
  std::string what;
};

// What is nearest to the ball's center.
Limit nearest_limit(const SafetyProblem& problem, const Obstacles& obstacles, const EnclosingBall& ball) {
  Limit nearest;
  const auto look = [&](double distance, const std::string& what) {
    if (!(distance >= nearest.distance)) nearest = {distance, what};  // NaN is near, too
  };
  look(norm_below(ball.center), "the goal");
  look(distance_below(*problem.initial, problem.workspace, ball.center), "the initial set");
  look(distance_to_sides(problem.contained, ball.center), "the workspace's edge");
  for (const RegionPtr& region : obstacles.fixed)
    look(distance_below(*region, problem.workspace, ball.center), "the obstacle " + region->describe());
  return nearest;
}

void check_options(const SceneRangeOptions& options, Eigen::Index places) {
  check(options.stretch > 0.0 && options.stretch <= kMostStretch,
        "range: found a stretch of {}, expected one in (0, {}]", options.stretch, kMostStretch);
  check(options.radius >= 0.0 && std::isfinite(options.radius),
        "range: found a radius of {}, expected one > 0", options.radius);
  check(options.half_sizes.size() == 0 ||
            (options.half_sizes.size() == places && (options.half_sizes.array() > 0.0).all()),
        "range: found {} half sizes, expected {} numbers > 0", options.half_sizes.size(), places);
}

std::string in_unit(const PreparedRun& setup, double normalised) {
  const Frame& frame = setup.data.frame;
  return fmt::format("{:.4g} {}", normalised * frame.position_scale,
                     frame.unit.empty() ? "units" : frame.unit);
}

// Four digits that are not more than the value, > 0, is.
std::string number_below(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 3.0);
  return fmt::format("{:.4g}", std::floor(value / unit * (1.0 - 1e-12)) * unit);
}

// Of a normalised length or velocity, rounded down: "12.9 mm (0.258 normalised)".
std::string below(const RunRecord& record, double value, double scale, const char* per) {
  const UserUnits units(record);
  const std::string text = fmt::format("{} {}{}", number_below(value * scale), units.name(), per);
  return units.in_data() ? text : fmt::format("{} ({} normalised)", text, number_below(value));
}
std::string length_below(const RunRecord& record, double length) {
  return below(record, length, record.data.frame.position_scale, "");
}
std::string speed_below(const RunRecord& record, double speed) {
  return below(record, speed, record.data.frame.velocity_scale, "/s");
}

EnclosingBall find_ball(const PreparedRun& setup, const Region& moving) {
  const SafetyProblem& problem = setup.problem;
  const std::optional<EnclosingBall> ball =
      enclosing_ball(moving, doubled(problem.workspace, problem.places()), problem.places());
  check(ball.has_value(), "range: found {}, expected a bounded obstacle with points in the workspace",
        moving.describe());
  return *ball;
}

}  // namespace

bool SceneRange::holds(const Vector& p) const {
  if (p.size() != displacement.places() || !(norm_above(p) <= radius)) return false;
  return half_sizes.size() == 0 || (p.array().abs() <= half_sizes.array()).all();
}

Points SceneRange::ends(int count) const {
  const Eigen::Index n = displacement.places();
  std::vector<Vector> directions;
  if (n == 2) {
    for (int k = 0; k < count; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / count;
      directions.push_back((Vector(2) << std::cos(angle), std::sin(angle)).finished());
    }
  } else {
    for (Eigen::Index i = 0; i < n; ++i)
      for (const double sign : {1.0, -1.0}) directions.emplace_back(sign * Vector::Unit(n, i));
    for (int k = 0; k < (n > 1 && n <= 6 ? 1 << n : 0); ++k) {
      Vector corner(n);
      for (Eigen::Index i = 0; i < n; ++i) corner[i] = (k >> i & 1) == 1 ? 1.0 : -1.0;
      directions.push_back(corner.normalized());
    }
  }
  Points found(std::ssize(directions), n);
  for (std::size_t k = 0; k < directions.size(); ++k) {
    double length = radius * (1.0 - 1e-12);
    for (Eigen::Index i = 0; i < half_sizes.size(); ++i)
      length = std::min(length, half_sizes[i] / std::abs(directions[k][i]) * (1.0 - 1e-12));
    found.row(static_cast<Eigen::Index>(k)) = length * directions[k].transpose();
  }
  return found;
}

SceneRange scene_range(const PreparedRun& setup, const RunRecord& record, const SceneRangeOptions& options) {
  const SafetyProblem& problem = setup.problem;
  const Certificate& certificate = record.certificate;
  check(certificate.guarantee == Guarantee::invariant && problem.workspace_margin != nullptr,
        "range: found the guarantee {}, expected invariant: what samples say of single points says nothing "
        "of a displaced "
        "scene",
        to_string(certificate.guarantee));
  check_options(options, problem.places());
  const Obstacles obstacles = split(setup, options.obstacle);
  const EnclosingBall ball = find_ball(setup, *obstacles.moving);
  const Limit limit = nearest_limit(problem, obstacles, ball);
  check(limit.distance > (1.0 + kLeastShare) * ball.radius,
        "range: found {} within {} of the middle of {}, expected it beyond the obstacle's own {}: there is "
        "no room to move it",
        limit.what, in_unit(setup, std::max(0.0, limit.distance)), obstacles.moving->describe(),
        in_unit(setup, ball.radius));
  SceneRange range{.obstacle = obstacles.moving->describe(),
                   .index = options.obstacle.value_or(-1),
                   .displacement = Displacement(ball.center, ball.radius, limit.distance),
                   .half_sizes = options.half_sizes,
                   .limit = limit.what};
  range.radius = range.displacement.largest(options.stretch);
  if (options.radius > 0.0) range.radius = std::min(range.radius, options.radius);
  if (range.half_sizes.size() > 0) range.radius = std::min(range.radius, norm_above(range.half_sizes));
  range.stretch = (Interval(range.radius) * range.displacement.lipschitz()).upper;
  if (certificate.disturbance_margin > 0.0)
    range.margin =
        std::max(0.0, (Interval(certificate.disturbance_margin) * (1.0 - Interval(range.stretch))).lower);
  return range;
}

SafetyProblem moved_problem(const PreparedRun& setup, const SceneRange& range, const Vector& p) {
  SafetyProblem moved = setup.problem;
  const Eigen::Index n = moved.dimension();
  Vector shift = Vector::Zero(n);
  shift.head(p.size()) = p;
  const Obstacles obstacles =
      split(setup, range.index < 0 ? std::nullopt : std::optional<std::int64_t>(range.index));
  std::vector<RegionPtr> all = obstacles.fixed;
  all.push_back(
      placed(obstacles.moving, no_rotation(n), shift, obstacles.moving->describe() + ", displaced"));
  moved.unsafe = unite(std::move(all));
  return moved;
}

std::string range_statement(const RunRecord& record, const SceneRange& range) {
  const UserUnits units(record);
  std::string text =
      fmt::format("Certified for every displacement p of {} ({}) by up to {} in any direction",
                  range.index < 0 ? std::string("the obstacle") : fmt::format("obstacle {}", range.index),
                  range.obstacle, length_below(record, range.radius));
  for (Eigen::Index i = 0; i < range.half_sizes.size(); ++i)
    text +=
        fmt::format("{}{}", i == 0 ? ", with |p_i| <= " : ", ", length_below(record, range.half_sizes[i]));
  text += fmt::format(
      ", at rest or on the way with a velocity p' that the controller is told: every motion x' = f_p(x) that "
      "starts in the "
      "displaced safe set {{B_p <= 0}}, which holds the initial set, stays in it for ever, never touches the "
      "displaced "
      "obstacle{} and converges to the goal. Nothing changes farther than {} from the obstacle's middle, "
      "where {} "
      "lies. Where the obstacle rests, no velocity grows by more than {:.0f} %.",
      range.index < 0 ? "" : " nor any other", units.length(range.displacement.outer()), range.limit,
      std::ceil(100.0 * range.stretch * (1.0 - 1e-12)));
  if (range.margin > 0.0)
    text += fmt::format(
        " Motions also stay in the safe set under any disturbance |w| <= {}, wherever in the range the "
        "obstacle is ({} where "
        "it was).",
        speed_below(record, range.margin), speed_below(record, record.certificate.disturbance_margin));
  if (record.orientation)
    text +=
        " The orientation follows as it would at y = T_p^-1(x), where the obstacle was, and so it is with "
        "what is claimed of it: " +
        orientation_sentence(record);
  if (!record.certificate.execution.model.empty())
    text +=
        " Nothing is certified of the motion as a robot executes it, nor of a shield, in the displaced "
        "scene.";
  return text;
}

}  // namespace s2nnds
