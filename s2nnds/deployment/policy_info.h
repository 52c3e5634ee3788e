#pragma once

#include <string>

#include "s2nnds/core/points.h"

namespace s2nnds {

// What an exported policy carries besides its networks.
struct PolicyInfo {
  std::string name;
  double position_scale = 1.0;  // positions in the data's unit / position_scale = normalised
  double velocity_scale = 1.0;  // normalised velocity * velocity_scale = data's unit per second
  std::string unit;
  std::string guarantee;
  std::string statement;
  Vector workspace_lower, workspace_upper;  // [n] normalised
  double disturbance_margin = 0.0;          // normalised velocity, 0: none was certified
  double float32_error = 0.0;               // bound on f's error in float32, normalised velocity
};

}  // namespace s2nnds
