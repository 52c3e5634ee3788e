// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/execution_options.h"

#include <fmt/format.h>

#include <map>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

const std::map<std::string, double> metres = {{"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}};

// The data's unit for 1 of the options' unit of length, or of a velocity's.
double data_units(const ExecutionOptions& options, const Frame& frame, double normalised_scale) {
  if (options.unit == "data") return 1.0;
  if (options.unit == "normalised") return normalised_scale;
  const auto from = metres.find(options.unit), to = metres.find(frame.unit);
  check(to != metres.end(),
        "execution.unit: found {}, but the data's unit is \"{}\"; expected one of m, cm, mm, or "
        "execution.unit = "
        "\"data\"",
        options.unit, frame.unit);
  return from->second / to->second;
}

// How many times as large as demonstrated the robot moves.
double enlargement(const ExecutionOptions& options, const Frame& frame) {
  if (!(options.extent > 0.0)) return 1.0;
  return options.extent * data_units(options, frame, frame.position_scale) / frame.position_scale;
}

std::string milliseconds(double seconds) { return fmt::format("{:.4g} ms", 1000.0 * seconds); }

}  // namespace

void ExecutionOptions::visit(FieldVisitor& v) {
  const std::string before = preset;
  v.field("preset", preset, {"none", "arm_1khz"});
  if (preset != before) {  // one was read: the other keys start from its numbers
    *this = {};
    if (before == "none") {
      preset = "arm_1khz";
      unit = "mm";
      period = delay = 0.001;
      position_error = velocity_error = 1.0;
      velocity_error_relative = 0.02;
    }
  }
  v.field("unit", unit, {"data", "mm", "m", "normalised"});
  v.field("period", period, at_least(0.0));
  v.field("delay", delay, at_least(0.0));
  v.field("lag", lag, at_least(0.0));
  v.field("position_error", position_error, at_least(0.0));
  v.field("velocity_error", velocity_error, at_least(0.0));
  v.field("velocity_error_relative", velocity_error_relative, {.low = 0.0, .high = 1.0, .open_high = true});
  v.field("speed", speed, above(0.0));
  v.field("extent", extent, at_least(0.0));
  v.field("damping", damping, at_least(0.0));
  v.field("convergence_radius", convergence_radius, at_least(0.0));
}

bool ExecutionOptions::is_ideal() const {
  return period == 0.0 && delay == 0.0 && lag == 0.0 && position_error == 0.0 && velocity_error == 0.0 &&
         velocity_error_relative == 0.0 && speed == 1.0;
}

ExecutionModel execution_model(const ExecutionOptions& options, const Frame& frame, double field_error) {
  const double size = enlargement(options, frame),
               length = data_units(options, frame, frame.position_scale) / frame.position_scale / size,
               velocity = data_units(options, frame, frame.velocity_scale) / frame.velocity_scale / size;
  // The roundings of these few operations.
  constexpr double up = 1.0 + 1e-14;
  return {.period = options.period / frame.time_scale() * up,
          .delay = options.delay / frame.time_scale() * up,
          .lag = options.lag / frame.time_scale() * up,
          .position_error = options.position_error * length * up,
          .velocity_error = options.velocity_error * velocity * up,
          .velocity_error_relative = options.velocity_error_relative,
          .field_error = field_error,
          .least_speed = options.speed,
          .most_speed = options.speed};
}

ExecutionDemand execution_demand(const ExecutionOptions& options, const Frame& frame) {
  ExecutionDemand demand{.model = execution_model(options, frame, 0.0)};
  if (options.convergence_radius > 0.0) {
    demand.convergence_radius = options.convergence_radius *
                                data_units(options, frame, frame.position_scale) / frame.position_scale /
                                enlargement(options, frame);
  }
  return demand;
}

double metres_per_normalised(const ExecutionOptions& options, const Frame& frame) {
  const auto unit = metres.find(frame.unit);
  check(
      unit != metres.end(),
      "execution.damping: found the data's unit \"{}\", expected m, cm or mm: a push moves an arm by metres",
      frame.unit);
  return frame.position_scale * unit->second * enlargement(options, frame);
}

std::string execution_in_words(const ExecutionOptions& options, const Frame& frame) {
  const std::string unit = frame.unit.empty() ? "units of the data" : frame.unit;
  const double length = data_units(options, frame, frame.position_scale),
               velocity = data_units(options, frame, frame.velocity_scale);
  std::string text = fmt::format(
      "{:.4g} times f, commanded from a reading every {} or sooner that is at most {} old and wrong by at "
      "most {:.4g} "
      "{} and held until the next; the robot's velocity differs from the command by at most {:.4g} {}/s",
      options.speed, milliseconds(options.period), milliseconds(options.delay),
      options.position_error * length, unit, options.velocity_error * velocity, unit);
  if (options.velocity_error_relative > 0.0)
    text += fmt::format(" and {:.4g} % of it", 100.0 * options.velocity_error_relative);
  if (options.lag > 0.0)
    text += fmt::format(", behind a lag of first order of {} that starts at the first command",
                        milliseconds(options.lag));
  if (options.extent > 0.0)
    text += fmt::format(
        ", where it moves {:.4g} times as large as demonstrated (all other lengths and speeds are those of "
        "the demonstrations' size)",
        enlargement(options, frame));
  return text;
}

}  // namespace s2nnds
