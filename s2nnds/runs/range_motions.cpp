// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/range_motions.h"

#include <algorithm>

#include "s2nnds/networks/moved_motion.h"
#include "s2nnds/runs/motion_report.h"

namespace s2nnds {

RangeMotions motions_at_ends(const PreparedRun& setup, const RunRecord& record, const SceneRange& range) {
  RangeMotions found;
  const std::vector<Deviation> before = deviations_of(setup, record.networks.dynamics());
  for (const Deviation& each : before) {
    found.mean_before += each.mean / static_cast<double>(before.size());
    found.largest_before = std::max(found.largest_before, each.largest);
  }
  const MovedMotion motion(record.networks, range.displacement);
  const Points ends = range.ends();
  PreparedRun moved = setup;
  const std::vector<Demonstration> shown = setup.train();
  for (Eigen::Index k = 0; k < ends.rows(); ++k) {
    const Vector p = ends.row(k).transpose();
    moved.problem = moved_problem(setup, range, p);
    const StateFunction f([&](const Points& x) { return motion.velocity(x, p); });
    const std::vector<Deviation> after = deviations_of(moved, f);
    for (const Deviation& each : after) {
      found.mean += each.mean / static_cast<double>(after.size() * static_cast<std::size_t>(ends.rows()));
      found.largest = std::max(found.largest, each.largest);
    }
    for (const Demonstration& each : shown) {
      // Starts that are not in the safe set, where a demonstration begins in no safe place, are promised nothing.
      if (motion.barrier(each.position.topRows(1), p)(0, 0) > 0.0) continue;
      ++found.motions;
      const Rollout rollout =
          roll_out(f, moved.problem, each.position.row(0).transpose(), setup.config.evaluation.rollout);
      if (rollout.stop == StopReason::reached_goal) ++found.arrived;
    }
  }
  return found;
}

}  // namespace s2nnds
