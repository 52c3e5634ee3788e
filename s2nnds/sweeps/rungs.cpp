#include "s2nnds/sweeps/rungs.h"

#include <numeric>

namespace s2nnds {

std::vector<TrialResult> read_results(const SweepFolder& folder, const std::vector<std::int64_t>& trials) {
  std::vector<TrialResult> results;
  for (const std::int64_t trial : trials) {
    if (auto result = read_result(folder.result(trial))) results.push_back(std::move(*result));
  }
  return results;
}

std::vector<std::int64_t> trials_of(const Sweep& sweep, std::int64_t rung,
                                    const std::vector<std::int64_t>& points) {
  std::vector<std::int64_t> trials;
  for (const std::int64_t point : points) {
    const std::int64_t first = sweep.id_of(rung, point);
    for (std::int64_t k = 0; k < sweep.trials_a_point(); ++k) trials.push_back(first + k);
  }
  return trials;
}

SweepState read_state(const Sweep& sweep, const SweepFolder& folder) {
  SweepState state;
  std::vector<std::int64_t> points(sweep.points.size());
  std::iota(points.begin(), points.end(), 0);
  while (true) {
    state.trials = trials_of(sweep, state.rung, points);
    state.of_rung = read_results(folder, state.trials);
    state.results.insert(state.results.end(), state.of_rung.begin(), state.of_rung.end());
    std::size_t next = 0;
    for (const std::int64_t trial : state.trials) {
      const bool there = next < state.of_rung.size() && state.of_rung[next].trial == trial;
      if (there) {
        ++next;
      } else {
        state.missing.push_back(trial);
      }
    }
    if (!state.complete() || state.rung + 1 == sweep.options.rungs()) return state;
    points = promoted(sweep.options.halving, rank_points(sweep, state.of_rung));
    ++state.rung;
  }
}

}  // namespace s2nnds
