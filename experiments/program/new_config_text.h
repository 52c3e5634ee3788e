// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/runs/scene.h"

namespace s2nnds::program {

// A commented configuration for what `new` found; it trains as it stands. `unit_is_guessed` and the --data that
// paths count from, "" when they are whole, go into comments.
std::string new_config_text(const Scene& scene, bool unit_is_guessed, const std::string& data_flag);

}  // namespace s2nnds::program
