// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/runs/scene.h"

namespace s2nnds::program {

// What the files did not tell.
struct Guesses {
  bool unit = false;
  bool quaternion_order = false;
};

// A commented configuration for what `new` found; it trains as it stands. The guesses and the --data that
// paths count from, "" when they are whole, go into comments.
std::string new_config_text(const Scene& scene, const Guesses& guesses, const std::string& data_flag);

}  // namespace s2nnds::program
