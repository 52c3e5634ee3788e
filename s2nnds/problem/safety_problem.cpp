// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/safety_problem.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "s2nnds/core/check.h"
#include "s2nnds/data/frame.h"
#include "s2nnds/data/orientation.h"
#include "s2nnds/problem/framed_region.h"
#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

// Demonstrations whose first points lie farther apart than this (a share of the largest coordinate) start in places
// of their own: one box around all would ask for motions from between them, where nothing was shown.
constexpr double kStartGap = 0.25;
// Of a phase, as shares of its start: the workspace's bounds, and how far X0 reaches on both sides of the start.
constexpr double kLeastPhase = -0.25, kMostPhase = 1.25, kStartSlack = 0.02;

// Where the user's coordinates and the normalised ones meet: sets come in as they are written, and places go
// out into messages in the same unit and frame.
class UserCoordinates {
 public:
  UserCoordinates(const std::string& frame, const Frame& data) : in_data_(frame == "data"), frame_(data) {}

  // The normalised set of a region as written.
  RegionPtr region(RegionPtr written) const {
    return in_data_ ? framed(std::move(written), frame_.goal, frame_.position_scale) : written;
  }
  // A box as written; normalised it is never smaller, so that what holds in it holds in the one written.
  Box box(const Box& written) const {
    if (!in_data_) return written;
    Box normalised = written;
    for (Eigen::Index i = 0; i < written.dimension(); ++i) {
      const Interval goal = frame_.goal[i], scale = frame_.position_scale;
      normalised.lower[i] = ((written.lower[i] - goal) / scale).lower;
      normalised.upper[i] = ((written.upper[i] - goal) / scale).upper;
    }
    return normalised;
  }
  // A normalised box as one would write it: in the data's frame rounded to four digits or more, outwards.
  Box outside(const Box& normalised) const {
    if (!in_data_) return normalised;
    return {(digits() * written(normalised.lower)).array().floor() / digits(),
            (digits() * written(normalised.upper)).array().ceil() / digits()};
  }
  // The same rounded inwards.
  Box inside(const Box& normalised) const {
    if (!in_data_) return normalised;
    return {(digits() * written(normalised.lower)).array().ceil() / digits(),
            (digits() * written(normalised.upper)).array().floor() / digits()};
  }
  Vector written(const Vector& normalised) const {
    return in_data_ ? frame_.to_data(normalised) : normalised;
  }

  // "(500, 200) mm", "(0.1, 0.2)"
  std::string text(const Vector& normalised) const {
    if (in_data_) return frame_.position_text(frame_.to_data(normalised));
    return fmt::format("({:.6g})", fmt::join(normalised, ", "));
  }
  // "(100, 0) mm to (900, 400) mm"
  std::string text(const Box& normalised) const {
    return text(normalised.lower) + " to " + text(normalised.upper);
  }
  // For messages about what was written in the wrong place.
  std::string hint() const {
    return in_data_ ? fmt::format("the goal is at {}", text(Vector::Zero(frame_.goal.size())))
                    : "problem.frame = \"normalised\": the goal is at the origin, the largest coordinate 1";
  }

 private:
  // The places after the decimal point that lengths are rounded to, as a power of ten.
  double digits() const { return std::pow(10.0, 4.0 - std::floor(std::log10(frame_.position_scale))); }

  bool in_data_;
  const Frame& frame_;
};

// The first points of the demonstrations: [demonstrations, n].
Points first_points(const std::vector<Demonstration>& demonstrations) {
  Points starts(static_cast<Eigen::Index>(demonstrations.size()), demonstrations.front().dimension());
  for (Eigen::Index k = 0; k < starts.rows(); ++k) {
    starts.row(k) = demonstrations[static_cast<std::size_t>(k)].position.row(0);
  }
  return starts;
}

// The box with the same centre and its sides times `factor`.
Box scaled(const Box& box, double factor) {
  const Vector center = box.center(), half = 0.5 * factor * (box.upper - box.lower);
  return {center - half, center + half};
}

Vector bound(const std::vector<double>& numbers, const char* key, Eigen::Index dimension) {
  check(std::ssize(numbers) == dimension, "problem.bounds.{}: found {} numbers, expected {}", key,
        numbers.size(), dimension);
  const Vector corner = Eigen::Map<const Vector>(numbers.data(), dimension);
  check(corner.allFinite(), "problem.bounds.{}: found ({}), expected finite numbers", key,
        fmt::join(numbers, ", "));
  return corner;
}

// X, and X shrunk by the containment: the same box where that is off.
struct Workspace {
  Box whole, contained;
};

Workspace make_workspace(const ProblemOptions& options, const UserCoordinates& user, Eigen::Index dimension) {
  const bool shrinks = options.containment > 0.0;
  if (options.bounds.lower.empty() && options.bounds.upper.empty()) {
    const Box whole = Box::cube(dimension, options.workspace);
    return {whole, shrinks ? Box::cube(dimension, options.containment * options.workspace) : whole};
  }
  const Box written{bound(options.bounds.lower, "lower", dimension),
                    bound(options.bounds.upper, "upper", dimension)};
  check((written.lower.array() < written.upper.array()).all(),
        "problem.bounds: found lower ({}) and upper ({}), expected lower < upper on every axis",
        fmt::join(options.bounds.lower, ", "), fmt::join(options.bounds.upper, ", "));
  const Box whole = user.box(written);
  const Box contained = shrinks ? scaled(whole, options.containment) : whole;
  check((contained.lower.array() < 0.0).all() && (contained.upper.array() > 0.0).all(),
        "problem.bounds: found {}, expected the goal inside {}({})", user.text(whole),
        shrinks ? "by more than problem.containment leaves " : "", user.hint());
  return {whole, contained};
}

Vector appended(const Vector& x, double last) {
  Vector longer(x.size() + 1);
  longer << x, last;
  return longer;
}

// The workspace of places, and what it is of states (x, s) whose phase starts at `start`.
Workspace with_phase(const Workspace& places, double start, double containment) {
  const auto extended = [&](const Box& box, double share) {
    const double middle = 0.5 * (kLeastPhase + kMostPhase) * start,
                 half = 0.5 * share * (kMostPhase - kLeastPhase) * start;
    return Box{appended(box.lower, middle - half), appended(box.upper, middle + half)};
  };
  return {extended(places.whole, 1.0), extended(places.contained, containment > 0.0 ? containment : 1.0)};
}

// What holds of places, as a region of states: whatever the phase is, or where it starts.
RegionOptions at_every_phase(RegionOptions places) {
  if (places.type == "none") return places;
  return {.type = "extrusion", .of = {std::move(places)}};
}
RegionOptions at_the_start(RegionOptions places, double start) {
  return {.type = "extrusion",
          .of = {std::move(places)},
          .from = (1.0 - kStartSlack) * start,
          .to = (1.0 + kStartSlack) * start};
}

// Of a sample that was read from a text file.
std::string line_of(const Demonstration& d, Eigen::Index row) {
  return d.lines.empty() ? "" : fmt::format(" (line {} of its file)", d.lines[static_cast<std::size_t>(row)]);
}

void check_demonstrations_inside(const Box& workspace, const std::vector<Demonstration>& demonstrations,
                                 const UserCoordinates& user) {
  for (std::size_t k = 0; k < demonstrations.size(); ++k) {
    const Points& position = demonstrations[k].position;
    check(position.rows() > 0 && position.cols() == workspace.dimension(),
          "problem: demonstration {} is [{}, {}], expected dimension {}", k, position.rows(), position.cols(),
          workspace.dimension());
    for (Eigen::Index row = 0; row < position.rows(); ++row) {
      const Vector x = position.row(row).transpose();
      if (workspace.contains(x)) continue;
      fail(
          "problem: demonstration {} is at {} at sample {}{}, outside of the workspace: expected it within "
          "{} "
          "(problem.workspace, problem.bounds)",
          k, user.text(x), row, line_of(demonstrations[k], row), user.text(workspace));
    }
  }
}

std::vector<double> numbers(const Vector& x) { return {x.begin(), x.end()}; }

// X0 with its place found in the demonstrations, where the options leave that open.
// Starts [K, n] that belong together: those joined by gaps below kStartGap (single linkage).
std::vector<Points> start_clusters(const Points& starts) {
  std::vector<std::vector<Eigen::Index>> clusters;
  for (Eigen::Index k = 0; k < starts.rows(); ++k) {
    std::vector<Eigen::Index> joined = {k};
    for (auto cluster = clusters.begin(); cluster != clusters.end();) {
      const bool near = std::any_of(cluster->begin(), cluster->end(), [&](Eigen::Index other) {
        return (starts.row(other) - starts.row(k)).norm() < kStartGap;
      });
      if (near) joined.insert(joined.end(), cluster->begin(), cluster->end());
      cluster = near ? clusters.erase(cluster) : cluster + 1;
    }
    clusters.push_back(std::move(joined));
  }
  std::vector<Points> parts;
  for (const auto& members : clusters) parts.emplace_back(starts(members, Eigen::all));
  return parts;
}

RegionOptions find_initial(const ProblemOptions& options, const Points& starts, const UserCoordinates& user,
                           const Box& contained) {
  const std::string& type = options.initial.type;
  if (type == "ball_auto") {
    check(options.initial.radius > 0.0, "problem.initial: radius is {}, expected > 0",
          options.initial.radius);
    const Vector mean = starts.colwise().mean().transpose();
    return {.type = "ball", .center = numbers(user.written(mean)), .radius = options.initial.radius};
  }
  if (type != "auto") return options.initial;
  const bool bounded = !options.bounds.lower.empty();
  const Box clip = bounded ? contained : Box::cube(starts.cols(), 1.0);
  RegionOptions all{.type = "union"};
  for (const Points& near : start_clusters(starts)) {
    const Box grown{near.colwise().minCoeff().transpose().array() - options.padding,
                    near.colwise().maxCoeff().transpose().array() + options.padding};
    const Box box = user.outside(grown).intersection(user.inside(clip));
    all.of.push_back({.type = "box", .lower = numbers(box.lower), .upper = numbers(box.upper)});
  }
  return all.of.size() == 1 ? all.of.front() : all;
}

// Arms with the unit of their joints, where the options leave that to the data.
void find_joint_unit(RegionOptions& region, const ProblemOptions& options, const Frame& frame) {
  for (RegionOptions& part : region.of) find_joint_unit(part, options, frame);
  if (region.type != "arm") return;
  check(
      options.frame == "data" && (frame.unit == "rad" || frame.unit == "deg"),
      "problem: arm: found coordinates in {} and problem.frame = \"{}\", expected joint angles (data.state = "
      "\"joints\") and \"data\"",
      frame.unit.empty() ? "no unit" : frame.unit, options.frame);
  check(region.joint_unit == "auto" || region.joint_unit == frame.unit,
        "problem: arm: found joint_unit = \"{}\", expected that of the data, {}", region.joint_unit,
        frame.unit);
  region.joint_unit = frame.unit;
}

// The obstacle as written, grown by what the tool sweeps.
RegionOptions find_unsafe(const ProblemOptions& options, const Frame& frame, Eigen::Index dimension) {
  if (options.tool.is_none()) return options.unsafe;
  check(frame.has_orientation() && dimension == 3 && options.frame == "data",
        "problem.tool: found {}-D positions{} and problem.frame = \"{}\", expected poses in 3-D "
        "(data.state = \"pose\") and \"data\"",
        dimension, frame.has_orientation() ? " with orientations" : "", options.frame);
  const Eigen::Vector4d goal = frame.goal_orientation;
  return swept(options.unsafe, options.tool, rotation_matrix(goal.normalized()));
}

// A point that both regions hold within the box, if one is found.
std::optional<Vector> common_point(const RegionPtr& a, const RegionPtr& b, const Box& within) {
  const RegionSampler sampler(intersect({a, b}), within);
  if (sampler.empty()) return std::nullopt;
  RandomStream random(0, "common-point");
  return sampler.sample(1, random).row(0).transpose();
}

// Sampling throws where the level is not a number.
void check_defined(const RegionPtr& region, const Box& workspace, const char* key) {
  constexpr Eigen::Index kProbes = 20000;
  RandomStream random(0, "problem-defined");
  Points probes = uniform_points(workspace, kProbes, random);
  probes.row(0).setZero();
  try {
    region->level(probes);
  } catch (const Error& error) {
    fail("{}: {}", key, error.what());
  }
}

void check_unsafe(const SafetyProblem& problem, const std::string& type, const UserCoordinates& user) {
  check_defined(problem.unsafe, problem.workspace, "problem.unsafe");
  const Vector goal = Vector::Zero(problem.dimension());
  check(!problem.unsafe->contains(goal), "problem.unsafe: {} covers the goal, at {}",
        problem.unsafe->describe(), user.text(goal));
  check(type == "none" || !RegionSampler(problem.unsafe, problem.workspace).empty(),
        "problem.unsafe: {} has no points in the workspace, {}: expected an obstacle there ({}); "
        "problem.workspace or problem.bounds make the workspace larger",
        problem.unsafe->describe(), user.text(problem.workspace), user.hint());
}

void check_initial(const SafetyProblem& problem, const Box& contained, const UserCoordinates& user) {
  // Beyond twice the workspace nobody looks.
  const Box around = scaled(problem.workspace, 2.0);
  check_defined(problem.initial, around, "problem.initial");
  const auto stray = common_point(problem.initial, complement(box_region(contained)), around);
  check(!stray, "problem.initial: {} reaches {}, outside of the {}: expected it within {}",
        problem.initial->describe(), stray ? user.text(*stray) : "",
        problem.workspace_margin ? "contained workspace" : "workspace", user.text(contained));
  check(!RegionSampler(problem.initial, problem.workspace).empty(),
        "problem.initial: {} is empty or has no volume in the workspace (problem.padding grows it)",
        problem.initial->describe());
  const auto unsafe_start = common_point(problem.initial, problem.unsafe, problem.workspace);
  check(!unsafe_start, "problem.initial: {} meets the unsafe set ({}) at {}", problem.initial->describe(),
        problem.unsafe->describe(), unsafe_start ? user.text(*unsafe_start) : "");
}

SafetyProblem build_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                            const Frame& frame, RegionFiles& files, bool checks) {
  validate(options);
  check(!demonstrations.empty(), "problem: no demonstrations, expected at least one");
  const Eigen::Index dimension = demonstrations.front().dimension();
  const Eigen::Index places = dimension - (frame.has_phase() ? 1 : 0);
  const UserCoordinates user(options.frame, frame);
  const Frame place_frame = frame.has_phase() ? frame.of_places() : frame;
  const UserCoordinates user_place(options.frame, place_frame);
  const Workspace of_places = make_workspace(options, user_place, places);
  SafetyProblem problem;
  problem.phase_start = frame.phase_start / frame.position_scale;
  const auto [whole, contained] =
      frame.has_phase() ? with_phase(of_places, problem.phase_start, options.containment) : of_places;
  problem.workspace = whole;
  if (checks) check_demonstrations_inside(problem.workspace, demonstrations, user);
  problem.contained = contained;
  problem.written_unsafe = find_unsafe(options, frame, places);
  find_joint_unit(problem.written_unsafe, options, frame);
  if (frame.has_phase()) problem.written_unsafe = at_every_phase(std::move(problem.written_unsafe));
  problem.unsafe = make_region(problem.written_unsafe, dimension, files, "problem.unsafe");
  if (options.unsafe.type != "none") problem.unsafe = user.region(problem.unsafe);
  if (checks) check_unsafe(problem, options.unsafe.type, user);
  if (options.containment > 0.0) problem.workspace_margin = complement(box_region(contained));
  problem.written_initial =
      find_initial(options, first_points(demonstrations).leftCols(places), user_place, of_places.contained);
  find_joint_unit(problem.written_initial, options, frame);
  if (frame.has_phase()) {
    problem.written_initial = at_the_start(std::move(problem.written_initial),
                                           options.frame == "data" ? frame.phase_start : problem.phase_start);
  }
  problem.initial = user.region(make_region(problem.written_initial, dimension, files, "problem.initial"));
  if (checks) check_initial(problem, contained, user);
  return problem;
}

}  // namespace

void BoundsOptions::visit(FieldVisitor& v) {
  v.field("lower", lower, any_number());
  v.field("upper", upper, any_number());
}

void ProblemOptions::visit(FieldVisitor& v) {
  v.field("frame", frame, {"data", "normalised"});
  v.field("workspace", workspace, above(0.0));
  v.group("bounds", bounds);
  v.field("containment", containment, {.low = 0.0, .high = 1.0, .open_high = true});
  v.field("padding", padding, at_least(0.0));
  v.group("initial", initial);
  v.group("unsafe", unsafe);
  v.group("tool", tool);
}

SafetyProblem make_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                           const Frame& frame, RegionFiles& files) {
  return build_problem(options, demonstrations, frame, files, true);
}

SafetyProblem draft_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                            const Frame& frame, RegionFiles& files) {
  return build_problem(options, demonstrations, frame, files, false);
}

SafetyProblem make_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                           const Frame& frame) {
  RegionFiles files;
  return make_problem(options, demonstrations, frame, files);
}

}  // namespace s2nnds
