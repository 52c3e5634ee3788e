// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/joint_angles.h"

#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// Returns how many samples were wrapped.
Eigen::Index unwrap(Recording& r, Eigen::Index joint, double turn, const std::string& unit) {
  Eigen::Index wraps = 0, before = -1;
  double added = 0.0;
  for (Eigen::Index i = 0; i < r.samples(); ++i) {
    double& angle = r.position(i, joint);
    if (!std::isfinite(angle)) continue;
    const double read = angle;
    if (before >= 0) {
      const double last = r.position(before, joint);
      const double turns = std::round((last - angle) / turn) * turn;
      if (turns != added) ++wraps;
      added = turns;
      angle += turns;
      check(std::abs(angle - last) <= 0.25 * turn,
            "{}: found joint {} at {:.4g} {} after {:.4g}, a step of {:.3g} of a turn whichever way; "
            "expected at "
            "most a quarter (lost samples, or an angle that wraps while it stands in a gap)",
            r.place(i), joint, read, unit, last, std::abs(angle - last) / turn);
    }
    before = i;
  }
  return wraps;
}

double end_of(const Recording& r, Eigen::Index joint) {
  for (Eigen::Index i = r.samples(); i-- > 0;)
    if (std::isfinite(r.position(i, joint))) return r.position(i, joint);
  return 0.0;
}

}  // namespace

void unwrap_joints(RecordingSet& set) {
  if (set.unit.empty()) set.unit = "rad";
  check(set.unit == "rad" || set.unit == "deg",
        "data.unit: found {} with data.state = \"joints\"; expected rad or deg", set.unit);
  const double turn = set.unit == "deg" ? 360.0 : 2.0 * M_PI;
  Eigen::Index wraps = 0, moved = 0;
  for (Recording& r : set.recordings) {
    for (Eigen::Index joint = 0; joint < r.position.cols(); ++joint) {
      wraps += unwrap(r, joint, turn, set.unit);
      const Recording& first = set.recordings.front();
      const double turns = std::round((end_of(first, joint) - end_of(r, joint)) / turn) * turn;
      if (turns == 0.0) continue;
      r.position.col(joint).array() += turns;
      ++moved;
    }
  }
  if (wraps > 0 || moved > 0) {
    set.report.push_back(
        fmt::format("joint angles unwrapped: {} jump(s) by a whole turn undone, {} angle(s) of whole "
                    "recordings moved by turns",
                    wraps, moved));
  }
}

}  // namespace s2nnds
