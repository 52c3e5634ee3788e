// SPDX-License-Identifier: BSD-3-Clause
// The time of single calls of f (2-64-64-64-2), a million of them: the exported header, its shield where that has to
// act, and the TorchScript policy. Prints one JSON object, microseconds. A call's time includes that of reading the clock. Usage:
// evaluation_latency [CALLS]
#include <fmt/format.h>
#include <torch/script.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "evaluated_policies.h"
#include "s2nnds/runs/threads.h"

namespace {

constexpr std::int64_t kWarmUp = 10000;

template <typename Evaluate>
void time_calls(nlohmann::ordered_json& json, const std::string& name, std::int64_t calls,
                const Evaluate& evaluate) {
  std::vector<float> micros(static_cast<std::size_t>(calls));
  double x[2] = {0.0, 0.3}, sum = 0.0;
  for (std::int64_t i = -kWarmUp; i < calls; ++i) {
    x[0] = 1e-6 * static_cast<double>(i);
    const auto begin = std::chrono::steady_clock::now();
    sum += evaluate(x);
    const auto end = std::chrono::steady_clock::now();
    if (i >= 0)
      micros[static_cast<std::size_t>(i)] = std::chrono::duration<float, std::micro>(end - begin).count();
  }
  std::sort(micros.begin(), micros.end());
  const auto at = [&](double share) {
    return micros[static_cast<std::size_t>(share * static_cast<double>(calls - 1))];
  };
  json[name + "_median_us"] = at(0.5);
  json[name + "_p999_us"] = at(0.999);
  json[name + "_worst_us"] = at(1.0);
  json[name + "_sum"] = sum;  // or the compiler might leave the calls out
}

}  // namespace

int main(int argc, char** argv) {
  const std::int64_t calls = argc > 1 ? std::stol(argv[1]) : 1000000;
  nlohmann::ordered_json json;
  json["calls"] = calls;
  const auto header = [](s2nnds::benchmarks::Velocity velocity) {
    return [velocity](const double* x) {
      double v[2];
      velocity(x, v);
      return v[0];
    };
  };
  time_calls(json, "eval", calls, header(s2nnds::benchmarks::float_policy(64)));
  time_calls(json, "eval_double", calls, header(s2nnds::benchmarks::double_policy(64)));
  time_calls(json, "shield", calls, [](const double* x) {
    const double wanted[2] = {1.0, -0.5 * x[0]};
    double v[2];
    return s2nnds::benchmarks::shielded_velocity(x, wanted, v) + v[0];
  });
  torch::InferenceMode inference;
  s2nnds::set_threads(1);
  torch::jit::Module policy = torch::jit::load(S2NNDS_POLICY_FOLDER "/width_64.pt");
  policy.eval();
  time_calls(json, "torchscript", calls, [&](const double* x) {
    const torch::Tensor point = torch::tensor({{static_cast<float>(x[0]), static_cast<float>(x[1])}});
    return policy.forward({point}).toTensor().data_ptr<float>()[0];
  });
  fmt::print("{}\n", json.dump());
  return 0;
}
