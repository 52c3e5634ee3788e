// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/rungs.h"

#include <numeric>

namespace s2nnds {
namespace {

// The rung's trials of the points, and the results that they have.
void read_rung(const Sweep& sweep, const SweepFolder& folder, const std::vector<std::int64_t>& points,
               SweepState& state) {
  state.trials.clear();
  state.of_rung.clear();
  for (const std::int64_t point : points) {
    const std::int64_t first = sweep.id_of(state.rung, point);
    for (std::int64_t trial = first; trial < first + sweep.trials_a_point(); ++trial) {
      state.trials.push_back(trial);
      if (auto result = read_result(folder.result(trial))) {
        state.of_rung.push_back(std::move(*result));
      } else {
        state.missing.push_back(trial);
      }
    }
  }
  state.results.insert(state.results.end(), state.of_rung.begin(), state.of_rung.end());
}

}  // namespace

SweepState read_state(const Sweep& sweep, const SweepFolder& folder) {
  SweepState state;
  std::vector<std::int64_t> points(sweep.points.size());
  std::iota(points.begin(), points.end(), 0);
  read_rung(sweep, folder, points, state);
  while (state.complete() && state.rung + 1 < sweep.options.rungs()) {
    points = promoted(sweep.options.halving, rank_points(sweep, state.of_rung));
    ++state.rung;
    read_rung(sweep, folder, points, state);
  }
  return state;
}

}  // namespace s2nnds
