// SPDX-License-Identifier: BSD-3-Clause
// Several obstacles: kinesthetic pick-and-place demonstrations in 3-D with three balls beside the motion, and
// a planar motion past three balls (0.03 m at (0.575, 0), (0.85, 0), (0.7, -0.175) m) from files as the robot
// records them: CSV, `time,x,y,dx,dy`, a row a millisecond, in metres. The robot's own
// recordings are not public; the five files are made here and written to OUT/recordings.
//
// Expected: every seed of both motions `invariant`.
//
// Usage: multi_obstacle --data DIR [--out FOLDER] [--quick]
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>

#include "driver.h"
#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/random.h"

namespace {

using namespace s2nnds::experiment;
using nlohmann::json;

// From (1, -0.42) down a cosine to (0, 0), in half metres, with minimum-jerk timing and a smooth deviation
// that ends at zero; the goal stands at (0.45, 0.10) m before the robot.
std::string recording(int index) {
  constexpr double kHalfMetre = 0.5, kSeconds = 3.0, kPi = std::numbers::pi;
  s2nnds::RandomStream random(1, "recording", static_cast<std::uint64_t>(index));
  const double lift = 0.03 * random.normal(), bend = 0.02 * random.normal(),
               seconds = kSeconds * (1 + 0.1 * random.uniform(-1, 1));
  std::string text = "time,x,y,dx,dy\n";
  const auto rows = static_cast<int>(seconds * 1000.0);
  for (int row = 0; row <= rows; ++row) {
    const double u = static_cast<double>(row) / rows;
    const double x = 1.0 - u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
    const double dx = -30.0 * u * u * (1.0 - u) * (1.0 - u) / seconds;
    const double y = -0.21 * (1.0 - std::cos(kPi * x)) + lift * x + bend * std::sin(kPi * x);
    const double dy = (-0.21 * kPi * std::sin(kPi * x) + lift + bend * kPi * std::cos(kPi * x)) * dx;
    text += fmt::format("{:.3f},{:.6f},{:.6f},{:.6f},{:.6f}\n", row * 1e-3, 0.45 + kHalfMetre * x,
                        0.10 + kHalfMetre * y, kHalfMetre * dx, kHalfMetre * dy);
  }
  return text;
}

// Writes the files and returns the assignment that names them.
std::string write_recordings(const std::string& folder) {
  std::filesystem::create_directories(folder);
  json files = json::array();
  for (int k = 0; k < 5; ++k) {
    const auto path = std::filesystem::absolute(folder) / fmt::format("demonstration_{}.csv", k);
    s2nnds::write_atomic_file(path, recording(k), "the recording");
    files.push_back(path.string());
  }
  return "data.files=" + files.dump();
}

std::vector<s2nnds::ListedTrial> trials(const Arguments& arguments) {
  std::vector<s2nnds::ListedTrial> all = with_price(seed_trials("pick_box", arguments));
  append(all, with_price(seed_trials("robot", arguments, {write_recordings(arguments.out + "/recordings")})));
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  return run_driver(
      argc, argv,
      {.name = "multi_obstacle",
       .about = "Several obstacles: 3-D pick-and-place, and a planar motion from CSV recordings",
       .configs = {"other/pick_box.toml", "recordings/robot.toml"},
       .trials = trials});
}
