// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/sweeps/rungs.h"

namespace s2nnds::program {

// Every trial with its settings, on stdout; as one JSON object if asked.
void print_trials(const Sweep& sweep, bool json);

// Writes table.h5 and table.csv and prints the best points of a crossed sweep, and one JSON object after them
// if asked. Returns whether a point has the wanted guarantee.
bool report_sweep(const Sweep& sweep, const SweepFolder& folder, const SweepState& state, bool json);

}  // namespace s2nnds::program
