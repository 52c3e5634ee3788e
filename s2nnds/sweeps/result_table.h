#pragma once

#include <string>
#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/sweeps/effects.h"
#include "s2nnds/sweeps/rungs.h"

namespace s2nnds {

// One row a trial: trial, rung, point, config, seed, every axis, status (done, failed, missing), error,
// guarantee, counts, seconds, every metric, run (the run file, relative to the sweep's folder).
struct TableColumn {
  std::string name;
  bool is_text = false;
  std::vector<double> numbers;  // NaN: not measured
  std::vector<std::string> texts;
};

struct ResultTable {
  std::vector<TableColumn> columns;
  std::vector<std::string> axes;  // names of the axes' columns
};

ResultTable make_table(const Sweep& sweep, const SweepState& state);

// Text columns quoted where they must be, numbers with all their digits, NaN as nothing.
std::string to_csv(const ResultTable& table);

// /trials/COLUMN, one dataset each; /effects/axis, from, to and, for each figure that is told, NAME and
// NAME_error. Attributes of the file: name, objective, direction, guarantee, dtw_limit, share, axes, columns;
// of /effects: figures; of each figure: kind (factor, difference) and trials.
void write_table(const std::string& path, const ResultTable& table, const EffectTable& effects,
                 const SweepOptions& options);

}  // namespace s2nnds
