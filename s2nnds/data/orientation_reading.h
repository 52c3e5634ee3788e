// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/data/recording.h"

namespace s2nnds {

// Makes of what files hold, [M, 4] quaternions in `order` ("xyzw" or "wxyz") or [M, 9] rotation matrices row by row,
// unit quaternions (w, x, y, z) that go on without jumps of sign; rows with missing numbers stay missing. Adds a line
// to the set's report. Throws Error naming the row for
// - a quaternion whose norm is not 1 to within a tenth, a matrix that is no rotation to within 0.05,
// - a turn of more than 60 degrees from one sample to the next; where it vanishes in the other order, that is said,
// - an orientation turned by 170 degrees or more from the recording's last one: seen from there, rotation vectors jump.
void make_unit_orientations(RecordingSet& set, const std::string& order);

}  // namespace s2nnds
