// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "commands.h"
#include "s2nnds/runs/scene_range.h"

// Displacements of an obstacle that a certificate covers without another proof.
namespace s2nnds::program {

// The range of a certified run. Throws Error as scene_range() does, and for numbers that are none.
SceneRange chosen_range(const RangeChoice& choice, const PreparedRun& setup, const RunRecord& record);

struct RangeArguments {
  std::string run;
  RangeChoice choice;
};
// Prints what is certified, and how far the motions at its ends are from the demonstrations.
int range(const RangeArguments& arguments, const CommonArguments& common);

}  // namespace s2nnds::program
