// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/rollout_events.h"

namespace s2nnds {
namespace {

using Mask = Eigen::Array<bool, Eigen::Dynamic, 1>;

Mask outside(const Box& box, const Points& x) {
  return (x.rowwise() - box.lower.transpose()).rowwise().minCoeff().array() < 0.0 ||
         (x.rowwise() - box.upper.transpose()).rowwise().maxCoeff().array() > 0.0;
}

Mask inside(const RegionPtr& region, const Points& x) {
  if (!region) return Mask::Constant(x.rows(), false);
  return region->level(x).array() <= 0.0;
}

void mark(const Mask& where, StopReason reason, std::vector<StopReason>& reasons) {
  for (Eigen::Index i = 0; i < where.size(); ++i) {
    if (where[i]) reasons[static_cast<std::size_t>(i)] = reason;
  }
}

}  // namespace

std::vector<StopReason> RolloutEvents::at(const Points& x) const {
  std::vector<bool> unsafe(static_cast<std::size_t>(x.rows()), false);
  if (at_sets_ && x.rows() > 0) {
    const Mask in_set = inside(problem_.unsafe, x);
    unsafe.assign(in_set.begin(), in_set.end());
  }
  return at(x, unsafe);
}

std::vector<StopReason> RolloutEvents::at(const Points& x, const std::vector<bool>& unsafe) const {
  std::vector<StopReason> reasons(static_cast<std::size_t>(x.rows()), StopReason::time_out);
  if (x.rows() == 0) return reasons;
  if (at_goal_) mark(x.rowwise().norm().array() <= goal_radius_, StopReason::reached_goal, reasons);
  if (at_sets_) {
    mark(outside(problem_.workspace, x) || inside(problem_.workspace_margin, x), StopReason::left_workspace,
         reasons);
    for (std::size_t i = 0; i < reasons.size(); ++i) {
      if (unsafe[i]) reasons[i] = StopReason::entered_unsafe;
    }
  }
  return reasons;
}

}  // namespace s2nnds
