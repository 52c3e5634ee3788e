// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/safety_problem.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

std::string text(const Vector& x) {
  return fmt::format("({:.6g})", fmt::join(x.data(), x.data() + x.size(), ", "));
}

// The first points of the demonstrations: [demonstrations, n].
Points first_points(const std::vector<Demonstration>& demonstrations) {
  Points starts(static_cast<Eigen::Index>(demonstrations.size()), demonstrations.front().dimension());
  for (Eigen::Index k = 0; k < starts.rows(); ++k) {
    starts.row(k) = demonstrations[static_cast<std::size_t>(k)].position.row(0);
  }
  return starts;
}

void check_demonstrations_inside(const Box& workspace, const std::vector<Demonstration>& demonstrations) {
  for (std::size_t k = 0; k < demonstrations.size(); ++k) {
    const Points& position = demonstrations[k].position;
    check(position.rows() > 0 && position.cols() == workspace.dimension(),
          "problem: demonstration {} is [{}, {}], expected dimension {}", k, position.rows(), position.cols(),
          workspace.dimension());
    for (Eigen::Index row = 0; row < position.rows(); ++row) {
      const Vector x = position.row(row).transpose();
      if (workspace.contains(x)) continue;
      fail(
          "problem: demonstration {} is at {} at sample {}, outside of the workspace: expected coordinates "
          "of at "
          "most {} (problem.workspace)",
          k, text(x), row, workspace.upper[0]);
    }
  }
}

RegionPtr make_initial(const ProblemOptions& options, const Points& starts, RegionFiles& files) {
  const std::string& type = options.initial.type;
  if (type == "ball_auto") {
    check(options.initial.radius > 0.0, "problem.initial: radius is {}, expected > 0",
          options.initial.radius);
    return ball(starts.colwise().mean().transpose(), options.initial.radius);
  }
  if (type != "auto") return make_region(options.initial, starts.cols(), files, "problem.initial");
  const Box clip = Box::cube(starts.cols(), 1.0);
  const Box grown{starts.colwise().minCoeff().transpose().array() - options.padding,
                  starts.colwise().maxCoeff().transpose().array() + options.padding};
  return box_region(grown.intersection(clip));
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
  Points probes(kProbes, workspace.dimension());
  for (Eigen::Index k = 0; k < probes.rows(); ++k) {
    for (Eigen::Index i = 0; i < probes.cols(); ++i) {
      probes(k, i) = random.uniform(workspace.lower[i], workspace.upper[i]);
    }
  }
  probes.row(0).setZero();
  try {
    region->level(probes);
  } catch (const Error& error) {
    fail("{}: {}", key, error.what());
  }
}

void check_unsafe(const SafetyProblem& problem, const std::string& type) {
  check_defined(problem.unsafe, problem.workspace, "problem.unsafe");
  const Vector goal = Vector::Zero(problem.dimension());
  check(!problem.unsafe->contains(goal), "problem.unsafe: {} covers the goal (the origin)",
        problem.unsafe->describe());
  check(type == "none" || !RegionSampler(problem.unsafe, problem.workspace).empty(),
        "problem.unsafe: {} has no points in the workspace; use type \"none\" for no obstacle",
        problem.unsafe->describe());
}

void check_initial(const SafetyProblem& problem, double containment) {
  const double half_width = problem.workspace.upper[0];
  const double reach = containment > 0.0 ? containment * half_width : half_width;
  // Beyond twice the workspace nobody looks.
  const Box around = Box::cube(problem.dimension(), 2.0 * half_width);
  check_defined(problem.initial, around, "problem.initial");
  const RegionPtr beyond = complement(box_region(Box::cube(problem.dimension(), reach)));
  const auto stray = common_point(problem.initial, beyond, around);
  check(!stray, "problem.initial: {} reaches {}, outside of the {}: expected coordinates below {:.6g}",
        problem.initial->describe(), stray ? text(*stray) : "",
        containment > 0.0 ? "contained workspace" : "workspace", reach);
  check(!RegionSampler(problem.initial, problem.workspace).empty(),
        "problem.initial: {} is empty or has no volume in the workspace (problem.padding grows it)",
        problem.initial->describe());
  const auto unsafe_start = common_point(problem.initial, problem.unsafe, problem.workspace);
  check(!unsafe_start, "problem.initial: {} meets the unsafe set ({}) at {}", problem.initial->describe(),
        problem.unsafe->describe(), unsafe_start ? text(*unsafe_start) : "");
}

}  // namespace

void ProblemOptions::visit(FieldVisitor& v) {
  v.field("workspace", workspace, above(0.0));
  v.field("containment", containment, {.low = 0.0, .high = 1.0, .open_high = true});
  v.field("padding", padding, at_least(0.0));
  v.group("initial", initial);
  v.group("unsafe", unsafe);
}

SafetyProblem make_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                           RegionFiles& files) {
  validate(options);
  check(!demonstrations.empty(), "problem: no demonstrations, expected at least one");
  const Eigen::Index dimension = demonstrations.front().dimension();
  SafetyProblem problem;
  problem.workspace = Box::cube(dimension, options.workspace);
  check_demonstrations_inside(problem.workspace, demonstrations);
  problem.unsafe = make_region(options.unsafe, dimension, files, "problem.unsafe");
  check_unsafe(problem, options.unsafe.type);
  if (options.containment > 0.0) {
    problem.workspace_margin =
        complement(box_region(Box::cube(dimension, options.containment * options.workspace)));
  }
  problem.initial = make_initial(options, first_points(demonstrations), files);
  check_initial(problem, options.containment);
  return problem;
}

SafetyProblem make_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations) {
  RegionFiles files;
  return make_problem(options, demonstrations, files);
}

}  // namespace s2nnds
