// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/deployment/policy.h"
#include "s2nnds/runs/scene_range.h"

namespace s2nnds {

// The part of an exported header (cpp_header.h) that speaks of displaced scenes: MovedMotion in the data's unit and frame,
// for each displacement p [places] of the range. Outside of the range nothing is answered: velocity() gives 0 and false,
// safe() false.
std::string displaced_source(const Policy& policy, const SceneRange& range);

}  // namespace s2nnds
