// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/data/recording.h"

namespace s2nnds {

// Takes positions for joint angles, in degrees where the set's unit is "deg" and else in radians ("" becomes "rad"):
// adds whole turns so that no angle jumps from one sample to the next, and to whole recordings so that each angle ends
// within half a turn of where the first recording's ends. Rows with missing numbers stay. Adds a line to the set's
// report where something was changed. Throws Error naming row and joint for a step of more than a quarter of a turn,
// which may have been the other way round, and for a unit of length.
void unwrap_joints(RecordingSet& set);

}  // namespace s2nnds
