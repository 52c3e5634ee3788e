// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/user_units.h"

#include <fmt/ranges.h>

#include <cmath>

namespace s2nnds {
namespace {

std::string number(double value) { return fmt::format("{:.4g}", value); }

}  // namespace

std::string UserUnits::name() const {
  const std::string& unit = record_.data.frame.unit;
  return unit.empty() ? "units of the data" : unit;
}

std::string UserUnits::length(double normalised) const {
  const std::string found =
      fmt::format("{} {}", number(normalised * record_.data.frame.position_scale), name());
  return in_data() ? found : fmt::format("{} ({} normalised)", found, number(normalised));
}

std::string UserUnits::speed(double normalised) const {
  const std::string found =
      fmt::format("{} {}/s", number(normalised * record_.data.frame.velocity_scale), name());
  return in_data() ? found : fmt::format("{} ({} normalised)", found, number(normalised));
}

std::string UserUnits::volume(double normalised) const { return power(normalised, record_.data.dimension); }

std::string UserUnits::area(double normalised) const {
  return power(normalised, record_.data.frame.places());
}

std::string UserUnits::power(double normalised, Eigen::Index n) const {
  const std::string found = fmt::format(
      "{} {}^{}", number(normalised * std::pow(record_.data.frame.position_scale, static_cast<double>(n))),
      name(), n);
  return in_data() ? found : fmt::format("{} normalised ({})", number(normalised), found);
}

std::string UserUnits::position(const std::vector<double>& normalised) const {
  const Frame& frame = record_.data.frame;
  const Vector z = Eigen::Map<const Vector>(normalised.data(), std::ssize(normalised));
  if (in_data()) return frame.position_text(frame.to_data(z));
  const Vector from_goal = frame.position_scale * z;
  return fmt::format("({:.6g}), which is ({:.6g}) {} from the goal", fmt::join(z, ", "),
                     fmt::join(from_goal, ", "), name());
}

std::string UserUnits::workspace() const {
  const Frame& frame = record_.data.frame;
  const Box& box = record_.problem.workspace;
  if (!in_data())
    return fmt::format("({:.6g}) to ({:.6g})", fmt::join(box.lower, ", "), fmt::join(box.upper, ", "));
  return fmt::format("{} to {}", frame.position_text(frame.to_data(box.lower), Frame::Rounding::up),
                     frame.position_text(frame.to_data(box.upper), Frame::Rounding::down));
}

}  // namespace s2nnds
