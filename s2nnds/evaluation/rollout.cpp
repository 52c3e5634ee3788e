// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/rollout.h"

#include <algorithm>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/dense_output_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/util/odeint_error.hpp>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/evaluation/rollout_events.h"

namespace s2nnds {
namespace {

namespace odeint = boost::numeric::odeint;
using State = std::vector<double>;

constexpr int kMostSteps = 50'000;
constexpr double kFirstStep = 1e-3;
constexpr int kBisections = 40;  // of a sub-step: to 1e-12 of it

// xdot = f(x), followed step by step; between the ends of a step the method's own interpolation holds.
class Motion {
 public:
  Motion(const StateFunction& f, const Vector& start, const RolloutOptions& options)
      : field_(f),
        point_(1, start.size()),
        stepper_(odeint::make_dense_output(options.absolute_tolerance, options.relative_tolerance,
                                           odeint::runge_kutta_dopri5<State>())),
        interpolated_(static_cast<std::size_t>(start.size())) {
    stepper_.initialize(State(start.begin(), start.end()), 0.0, kFirstStep);
  }

  // False when the step failed: no step is short enough, or the state is no longer finite.
  bool step() {
    if (++steps_ > kMostSteps) return false;
    try {
      stepper_.do_step([this](const State& x, State& velocity, double) { evaluate(x, velocity); });
    } catch (const odeint::odeint_error&) {
      return false;
    }
    const State& state = stepper_.current_state();
    return std::all_of(state.begin(), state.end(), [](double value) { return std::isfinite(value); });
  }

  double step_begin() const { return stepper_.previous_time(); }
  double step_end() const { return stepper_.current_time(); }

  // The position at a time within the last step: [n].
  Eigen::RowVectorXd at(double time) {
    stepper_.calc_state(time, interpolated_);
    return Eigen::Map<const Eigen::RowVectorXd>(interpolated_.data(), point_.cols());
  }

 private:
  void evaluate(const State& x, State& velocity) {
    point_ = Eigen::Map<const Eigen::RowVectorXd>(x.data(), point_.cols());
    const Points found = field_.value(point_);
    velocity.assign(found.data(), found.data() + found.size());
  }

  const StateFunction& field_;
  Points point_;  // [1, n]
  odeint::result_of::make_dense_output<odeint::runge_kutta_dopri5<State>>::type stepper_;
  State interpolated_;
  int steps_ = 0;
};

struct Samples {
  Vector time;      // [M], after the step's begin
  Points position;  // [M, n]
};

// `count` equally spaced samples of the last step, up to the time `end`.
Samples sample_step(Motion& motion, double end, Eigen::Index count, Eigen::Index dimension) {
  Samples samples{Vector(count), Points(count, dimension)};
  const double begin = motion.step_begin();
  for (Eigen::Index i = 0; i < count; ++i) {
    samples.time[i] = i + 1 == count
                          ? end
                          : begin + (end - begin) * static_cast<double>(i + 1) / static_cast<double>(count);
    samples.position.row(i) = motion.at(samples.time[i]);
  }
  return samples;
}

double longest_gap(const Eigen::RowVectorXd& before, const Points& position) {
  double longest = (position.row(0) - before).norm();
  for (Eigen::Index i = 1; i < position.rows(); ++i) {
    longest = std::max(longest, (position.row(i) - position.row(i - 1)).norm());
  }
  return longest;
}

// The last step up to the time `end`, in sub-steps of at most look_spacing of length.
Samples follow_step(Motion& motion, double end, Eigen::Index dimension) {
  const Eigen::RowVectorXd before = motion.at(motion.step_begin());
  Samples samples = sample_step(motion, end, 2, dimension);
  while (longest_gap(before, samples.position) > look_spacing && samples.time.size() < most_looks) {
    samples = sample_step(motion, end, 2 * samples.time.size(), dimension);
  }
  return samples;
}

// The first moment in (before, after] at which something has happened, given that it has at `after`.
double locate(Motion& motion, const RolloutEvents& events, double before, double after) {
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (before + after);
    (events.at_point(motion.at(middle)) == StopReason::time_out ? before : after) = middle;
  }
  return after;
}

class Recorder {
 public:
  explicit Recorder(Eigen::Index dimension) : dimension_(dimension) {}

  void add(double time, const Eigen::RowVectorXd& position) {
    times_.push_back(time);
    positions_.insert(positions_.end(), position.begin(), position.end());
  }

  Rollout finish(StopReason stop) const {
    const auto count = static_cast<Eigen::Index>(times_.size());
    return {.time = Eigen::Map<const Vector>(times_.data(), count),
            .position = Eigen::Map<const Points>(positions_.data(), count, dimension_),
            .stop = stop};
  }

 private:
  Eigen::Index dimension_;
  std::vector<double> times_;
  std::vector<double> positions_;
};

// Records the samples up to the first event, then the event itself, and says which it was (time_out: none).
StopReason record(Motion& motion, const RolloutEvents& events, const Samples& samples, Recorder& recorder) {
  const std::vector<StopReason> reasons = events.at(samples.position);
  for (Eigen::Index i = 0; i < samples.time.size(); ++i) {
    if (reasons[static_cast<std::size_t>(i)] == StopReason::time_out) {
      recorder.add(samples.time[i], samples.position.row(i));
      continue;
    }
    const double before = i > 0 ? samples.time[i - 1] : motion.step_begin();
    const double moment = locate(motion, events, before, samples.time[i]);
    const Eigen::RowVectorXd position = motion.at(moment);
    recorder.add(moment, position);
    return events.at_point(position);
  }
  return StopReason::time_out;
}

void check_start(const StateFunction& f, const Vector& start, const char* where) {
  check(start.size() > 0 && start.allFinite(),
        "{}: found a start that is empty or not finite, expected numbers", where);
  check_outputs(f, start, start.size(), where);
}

}  // namespace

std::string_view to_string(StopReason reason) {
  switch (reason) {
    case StopReason::reached_goal:
      return "reached_goal";
    case StopReason::entered_unsafe:
      return "entered_unsafe";
    case StopReason::left_workspace:
      return "left_workspace";
    case StopReason::time_out:
      return "time_out";
    case StopReason::step_failed:
      return "step_failed";
  }
  fail("stop reason: found the value {}, expected 0 to 4", static_cast<int>(reason));
}

void RolloutOptions::visit(FieldVisitor& v) {
  v.field("goal_radius", goal_radius, above(0));
  v.field("duration", duration, above(0));
  v.field("absolute_tolerance", absolute_tolerance, above(0));
  v.field("relative_tolerance", relative_tolerance, above(0));
  v.field("stop_at_goal", stop_at_goal);
  v.field("stop_at_unsafe", stop_at_unsafe);
}

Rollout roll_out(const StateFunction& f, const SafetyProblem& problem, const Vector& start,
                 const RolloutOptions& options) {
  validate(options);
  check_start(f, start, "roll_out");
  check(start.size() == problem.dimension(), "roll_out: found a start of dimension {}, expected {}",
        start.size(), problem.dimension());
  const RolloutEvents events(problem, options.goal_radius, options.stop_at_goal, options.stop_at_unsafe);
  Motion motion(f, start, options);
  Recorder recorder(start.size());
  recorder.add(0.0, start.transpose());
  StopReason stop = events.at_point(start.transpose());
  while (stop == StopReason::time_out) {
    if (!motion.step()) return recorder.finish(StopReason::step_failed);
    const double end = std::min(motion.step_end(), options.duration);
    stop = record(motion, events, follow_step(motion, end, start.size()), recorder);
    if (end >= options.duration) break;
  }
  return recorder.finish(stop);
}

Points roll_out_at(const StateFunction& f, const Vector& start, const Vector& times,
                   const RolloutOptions& options) {
  validate(options);
  check_start(f, start, "roll_out_at");
  Motion motion(f, start, options);
  Points position(times.size(), start.size());
  double reached = 0.0;
  double previous = 0.0;
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    check(times[i] >= previous && std::isfinite(times[i]),
          "roll_out_at: found the time {} after {}, expected ascending times from 0", times[i], previous);
    previous = times[i];
    while (reached < times[i]) {
      if (!motion.step()) {
        position.bottomRows(times.size() - i).setConstant(std::numeric_limits<double>::quiet_NaN());
        return position;
      }
      reached = motion.step_end();
    }
    if (reached > 0.0) {
      position.row(i) = motion.at(times[i]);
    } else {
      position.row(i) = start.transpose();
    }
  }
  return position;
}

}  // namespace s2nnds
