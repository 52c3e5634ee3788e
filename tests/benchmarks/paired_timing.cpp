// SPDX-License-Identifier: BSD-3-Clause
// Our side of compare.sh: the work of the peer's script, timed as it times it. Prints one JSON object; times
// are medians in seconds. Usage: paired_timing [--threads N] [--steps N] [--repeats N]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <vector>

#include "s2nnds/networks/dense_kernels.h"
#include "s2nnds/runs/threads.h"
#include "work.h"

namespace {

using namespace s2nnds::benchmarks;

template <typename Work>
double median_seconds(Work& work, int warm_up, int count) {
  std::vector<double> seconds;
  for (int i = 0; i < warm_up + count; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work.run();
    if (i >= warm_up) {
      seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
  }
  std::nth_element(seconds.begin(), seconds.begin() + count / 2, seconds.end());
  return seconds[static_cast<std::size_t>(count / 2)];
}

}  // namespace

int main(int argc, char** argv) {
  int threads = 0, steps = 200, repeats = 5;
  CLI::App app("Times the joint training step and the scoring of 200,000 points.");
  app.add_option("--threads", threads);
  app.add_option("--steps", steps)->check(CLI::PositiveNumber);
  app.add_option("--repeats", repeats)->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  s2nnds::set_threads(threads);
  torch::manual_seed(0);
  const int used = s2nnds::thread_counts().loops;

  TrainingStep step({});
  Scoring scoring({}, 200000);
  nlohmann::ordered_json json;
  json["threads"] = used;
  json["instruction_set"] = s2nnds::dense_kernels<float>().instruction_set;
  json["step_s"] = median_seconds(step, 20, steps);
  json["score_200k_s"] = median_seconds(scoring, 1, repeats);
  json["step_flops"] = step.flops();
  json["score_flops"] = scoring.flops();
  fmt::print("{}\n", json.dump());
  return 0;
}
