// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/evaluation_run.h"

#include <algorithm>

#include "s2nnds/core/stopwatch.h"
#include "s2nnds/data/orientation.h"
#include "s2nnds/evaluation/orientation_metrics.h"
#include "s2nnds/evaluation/safe_area.h"
#include "s2nnds/evaluation/trajectory_metrics.h"
#include "s2nnds/problem/grid_level.h"
#include "s2nnds/runs/motion_report.h"

namespace s2nnds {
namespace {

Grid make_grid(const PreparedRun& setup, const Networks& networks) {
  const Eigen::Index n = setup.problem.dimension();
  const bool in_plane_with_phase = n == 3 && setup.problem.has_phase();
  const Eigen::Index side = std::min<Eigen::Index>(n == 2                ? setup.config.evaluation.grid_points
                                                   : in_plane_with_phase ? 81
                                                                         : 41,
                                                   setup.config.evaluation.grid_points);
  Grid grid;
  const Box& x = setup.problem.workspace;
  for (Eigen::Index k = 0; k < n; ++k) {
    // Of a phase, eighths of its start: 0 and the start are among them.
    const Eigen::Index points = in_plane_with_phase && k == 2 ? 13 : side;
    grid.axes.push_back(Vector::LinSpaced(points, x.lower[k], x.upper[k]));
  }
  const Points points = grid_points(grid.axes);
  grid.unsafe = grid_level(*setup.problem.unsafe, grid.axes);
  grid.initial = grid_level(*setup.problem.initial, grid.axes);
  grid.V = networks.V.value(points);
  grid.B = networks.B.value(points);
  grid.velocity = networks.velocity(points);
  return grid;
}

std::vector<StoredRollout> make_rollouts(const PreparedRun& setup, const RunRecord& record) {
  const Dynamics f = record.networks.dynamics();
  const Frame& frame = setup.data.frame;
  std::vector<StoredRollout> rollouts;
  const auto add = [&](const std::vector<Demonstration>& demonstrations, const std::string& kind) {
    for (const Demonstration& d : demonstrations) {
      const Rollout rollout =
          roll_out(f, setup.problem, d.position.row(0).transpose(), setup.config.evaluation.rollout);
      rollouts.push_back({kind, std::string(to_string(rollout.stop)), rollout.time, rollout.position});
      if (!record.orientation) continue;
      const Eigen::Vector4d start = d.orientation.row(0).transpose();
      rollouts.back().orientation = record.orientation->follow(
          frame.goal_orientation, frame.time_scale() * rollout.time, rollout.position, start);
    }
  };
  add(setup.train(), "train");
  add(setup.test(), "test");
  return rollouts;
}

// In degrees.
void measure_orientations(const PreparedRun& setup, const RunRecord& record, EvaluationSummary& summary) {
  const auto measure = [&](const std::vector<Demonstration>& demonstrations, double& mean, double& largest) {
    const OrientationErrors found =
        orientation_errors(record.networks.dynamics(), *record.orientation, setup.data.frame, demonstrations,
                           setup.config.evaluation.rollout);
    mean = degrees(found.mean);
    largest = degrees(found.largest);
  };
  measure(setup.train(), summary.orientation_mean_train, summary.orientation_largest_train);
  if (!setup.data.split.test.empty())
    measure(setup.test(), summary.orientation_mean_test, summary.orientation_largest_test);
}

}  // namespace

void evaluate_motion(const PreparedRun& setup, RunRecord& record) {
  const Networks& networks = record.networks;
  const Dynamics dynamics = networks.dynamics();
  const RolloutOptions& rollout = setup.config.evaluation.rollout;
  const Eigen::Index places = setup.problem.places();
  const MotionErrors train_errors = motion_errors(dynamics, setup.train(), rollout, places);
  EvaluationSummary summary;
  summary.mse_train = train_errors.mse;
  summary.sd_train = train_errors.sd;
  summary.dtw_train = train_errors.dtw;
  if (!setup.data.split.test.empty()) {
    const MotionErrors test = motion_errors(dynamics, setup.test(), rollout, places);
    summary.mse_test = test.mse;
    summary.sd_test = test.sd;
    summary.dtw_test = test.dtw;
    summary.dtw_independent_test = test.dtw_independent;
  }
  if (!setup.data.split.validation.empty()) {
    summary.mse_validation = motion_errors(dynamics, setup.validation(), rollout, places).mse;
  }
  const std::vector<Deviation> from_shown = deviations_of(setup, dynamics);
  summary.deviation_mean = summary.deviation_largest = summary.not_followed = 0.0;
  for (const Deviation& each : from_shown) {
    summary.deviation_mean = std::max(summary.deviation_mean, each.mean);
    summary.deviation_largest = std::max(summary.deviation_largest, each.largest);
    summary.not_followed += each.follows() ? 0.0 : 1.0;
  }
  if (record.orientation) measure_orientations(setup, record, summary);
  const std::vector<Deviation> from_initial = start_deviations_of(setup, dynamics);
  summary.starts_not_followed = static_cast<double>(std::count_if(
      from_initial.begin(), from_initial.end(), [](const Deviation& each) { return !each.follows(); }));
  record.evaluation = summary;
  record.remarks = motion_remarks(setup, record, from_shown, from_initial);
  record.rollouts = make_rollouts(setup, record);
  record.grid.reset();
  if (setup.problem.dimension() <= 3) record.grid = make_grid(setup, networks);
}

void evaluate(const PreparedRun& setup, RunRecord& record) {
  const Stopwatch watch;
  evaluate_motion(setup, record);
  const SafeArea area = measure_safe_area(record.networks.dynamics(), record.networks.B, setup.problem,
                                          static_cast<int>(setup.config.evaluation.area_cells));
  record.evaluation.safe_area = area.safe_area;
  record.evaluation.true_safe_area = area.true_safe_area;
  record.evaluation.safe_area_ratio = area.ratio();
  record.timing.evaluation = watch.seconds();
}

}  // namespace s2nnds
