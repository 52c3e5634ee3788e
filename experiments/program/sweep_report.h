#pragma once

#include <string>

#include "s2nnds/sweeps/effects.h"
#include "s2nnds/sweeps/rungs.h"

namespace s2nnds::program {

// Every trial with its settings, on stdout; as one JSON object if asked.
void print_trials(const Sweep& sweep, bool json);

// Writes table.h5 and table.csv.
void write_tables(const Sweep& sweep, const SweepFolder& folder, const SweepState& state,
                  const EffectTable& effects);

// Prints the best points of a crossed sweep and the axes' effects, and one JSON object after them if asked.
// Returns whether a point has the wanted guarantee.
bool print_report(const Sweep& sweep, const SweepFolder& folder, const SweepState& state,
                  const EffectTable& effects, bool json);

}  // namespace s2nnds::program
