#pragma once

#include <string>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {

// What a motion must satisfy, in normalised, goal-centred coordinates (the goal is the origin).
struct SafetyProblem {
  Box workspace;               // X
  RegionPtr initial;           // X0
  RegionPtr unsafe;            // Xu, the obstacle
  RegionPtr shell;             // outside of containment * X; entering it counts as leaving the workspace. May be null
  double containment = 0.97;   // the safe set must lie in containment * X

  Eigen::Index dimension() const { return workspace.dimension(); }
};

struct ProblemOptions {
  double workspace = 1.25;     // X = [-workspace, workspace]^n
  bool contain = true;         // require {B <= 0} inside containment * X
  double containment = 0.97;
  double padding = 0.02;       // X0 of type "auto": box around the demonstrations' first points, grown by this
  RegionOptions initial = {.type = "auto"};  // "auto", "ball_auto" (ball of `radius` around their mean), or any region
  RegionOptions unsafe;

  void visit(FieldVisitor& v);
};

// Builds the sets and checks them: throws Error when the obstacle covers the goal, when X0 meets Xu or is empty or
// leaves the workspace, or when demonstrations leave the workspace. `demonstrations` are normalised.
SafetyProblem make_problem(const ProblemOptions& options, const std::vector<Demonstration>& demonstrations,
                           const std::string& data_dir = "");

}  // namespace s2nnds
