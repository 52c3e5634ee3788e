// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/sweeps/rungs.h"

namespace s2nnds {

// Writes table.csv and table.h5 into the sweep's folder. One row a trial: trial, rung, point, config, seed,
// every axis (of a list: profile and test), status (done, failed, missing), error, guarantee, counts,
// seconds, every metric, run (the run file, relative to the folder). In table.csv a number that was not
// measured is an empty cell. table.h5: /trials/COLUMN, one dataset each, NaN for what was not measured.
// Attributes of the file: name, objective, direction, guarantee, dtw_limit, share, axes, columns; of an axis:
// scale (list, linear, log) and values (all of a list, the ends of a range). Of a conformal sweep also beta_split_over, the
// number of trials by which each trial's beta is divided.
void write_tables(const Sweep& sweep, const SweepFolder& folder, const SweepState& state);

}  // namespace s2nnds
