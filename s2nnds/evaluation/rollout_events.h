// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/evaluation/rollout.h"

namespace s2nnds {

// A motion is looked at whenever it has gone on by this normalised length.
inline constexpr double look_spacing = 0.005;
// Looks in one step of the integration, at most: a step longer than 5 belongs to a motion that escapes.
inline constexpr Eigen::Index most_looks = 1 << 10;

// What ends a motion: the goal, the unsafe set, the edge of the workspace or its margin. Keeps references to
// what it is made from.
class RolloutEvents {
 public:
  // `at_goal`, `at_sets`: whether reaching the goal, and entering the sets, end the motion.
  RolloutEvents(const SafetyProblem& problem, double goal_radius, bool at_goal, bool at_sets)
      : problem_(problem), goal_radius_(goal_radius), at_goal_(at_goal), at_sets_(at_sets) {}

  // What happens at each of N finite points [N, n]; time_out stands for nothing. A point in several sets is
  // judged by the worst: unsafe, then outside, then the goal.
  std::vector<StopReason> at(const Points& x) const;
  // The same where it is known already which of the points lie in the unsafe set.
  std::vector<StopReason> at(const Points& x, const std::vector<bool>& unsafe) const;
  // What happens at one finite point [n].
  StopReason at_point(const Eigen::RowVectorXd& x) const { return at(Points(x)).front(); }

 private:
  const SafetyProblem& problem_;
  double goal_radius_;
  bool at_goal_;
  bool at_sets_;
};

}  // namespace s2nnds
