// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/frame.h"

#include <cmath>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

double scale_of(const std::string& normalization, const Points& points) {
  return normalization == "max_norm" ? points.rowwise().norm().maxCoeff() : points.cwiseAbs().maxCoeff();
}

bool is_scale(double value) { return value > 0.0 && std::isfinite(value); }

}  // namespace

std::vector<Demonstration> Frame::normalize(const std::vector<Demonstration>& as_read) const {
  s2nnds::check(static_cast<Eigen::Index>(as_read.size()) == goals.rows(),
                "frame: found {} demonstrations, expected {} as its goals", as_read.size(), goals.rows());
  std::vector<Demonstration> normalized = as_read;
  for (std::size_t k = 0; k < normalized.size(); ++k) {
    Demonstration& d = normalized[k];
    d.time.array() -= double(d.time[0]);
    d.time /= time_scale();
    d.position.rowwise() -= goals.row(static_cast<Eigen::Index>(k));
    d.position /= position_scale;
    d.velocity /= velocity_scale;
  }
  return normalized;
}

void Frame::check(std::size_t count, Eigen::Index dimension, const std::string& where) const {
  s2nnds::check(is_scale(position_scale) && is_scale(velocity_scale),
                "{}: found position_scale {} and velocity_scale {}, expected numbers > 0", where,
                position_scale, velocity_scale);
  s2nnds::check(goals.rows() == static_cast<Eigen::Index>(count) && goals.cols() == dimension,
                "{}: found goals [{}, {}], expected [{}, {}]", where, goals.rows(), goals.cols(), count,
                dimension);
  s2nnds::check(goals.allFinite(), "{}: found a goal that is NaN or infinite, expected finite numbers",
                where);
}

Frame find_frame(const DemonstrationSet& as_read, const std::string& normalization) {
  check(normalization == "max_abs" || normalization == "max_norm",
        "normalization: found '{}'; expected max_abs or max_norm", normalization);
  const auto count = static_cast<Eigen::Index>(as_read.demonstrations.size());
  Frame frame{.unit = as_read.unit, .normalization = normalization, .goals = {}};
  frame.goals.resize(count, as_read.dimension());
  for (Eigen::Index k = 0; k < count; ++k) {
    frame.goals.row(k) = as_read.demonstrations[static_cast<std::size_t>(k)].position.bottomRows(1);
  }
  const std::vector<Demonstration> from_goal = frame.normalize(as_read.demonstrations);  // scales of 1
  frame.position_scale = scale_of(normalization, stack_positions(from_goal));
  frame.velocity_scale = scale_of(normalization, stack_velocities(from_goal));
  check(frame.position_scale > 0 && frame.velocity_scale > 0,
        "normalization: found largest position {} and velocity {}; expected a motion, both > 0",
        frame.position_scale, frame.velocity_scale);
  return frame;
}

}  // namespace s2nnds
