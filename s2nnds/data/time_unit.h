// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/data/recording.h"

namespace s2nnds {

// Brings the times of all recordings to seconds and reports the unit unless it is the second. `unit` is s, ms,
// us or ns, or auto, which takes the first of these that decides:
// 1. the column's name: t_ms, time [ns], nsecs;
// 2. times of this century counted from 1970, in the one unit in which they are;
// 3. recorded velocities, which are the derivative of the positions in one unit;
// 4. the size: the one unit in which the recordings last 0.5 to 120 s with samples 0.5 ms to 0.3 s apart; else
//    the one in which they last 0.05 to 3600 s with samples 50 us to 2 s apart; else seconds.
// Throws Error naming the column when two units are as likely, or when the recordings disagree. Times counted
// from 1970 in another unit than the second start at 0 afterwards.
void bring_to_seconds(RecordingSet& set, const std::string& unit);

}  // namespace s2nnds
