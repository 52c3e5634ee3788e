// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/runs/config.h"

namespace s2nnds {

// Makes networks and training those of the profile `smooth`, on which proofs in four dimensions end: few neurons that start
// with small weights, so that boxes may be large, and conditions that are asked to hold by more.
void make_smooth(Config& config);

}  // namespace s2nnds
