// SPDX-License-Identifier: BSD-3-Clause
// Writes the policy that the evaluation benchmarks run, f of 2-WIDTH-WIDTH-WIDTH-2 with random weights, as a
// header and as TorchScript: FOLDER/width_WIDTH.h and .pt. Run by the build. Usage: policy_exporter FOLDER
// WIDTH...
#include <string>

#include "s2nnds/deployment/export_format.h"
#include "work.h"

int main(int argc, char** argv) {
  using namespace s2nnds;
  for (int k = 2; k < argc; ++k) {
    const std::string stem = std::string(argv[1]) + "/width_" + argv[k];
    NetworkOptions options;
    options.f.network.hidden.assign(3, std::stol(argv[k]));
    RandomStream random(0, "evaluation");
    Policy policy;
    policy.networks = {VectorField(2, options.f, random)->snapshot(),
                       Lyapunov(2, options.V, random)->snapshot(), Barrier(2, options.B, random)->snapshot()};
    policy.info.name = "benchmark";
    policy.info.guarantee = "none";
    policy.info.weight_hash = weight_hash(policy.networks);
    policy.info.dimension = 2;
    policy.info.goal = {0.0, 0.0};
    policy.info.workspace = {-1.25, -1.25, 1.25, 1.25};
    policy.info.executed = policy.info.shielded = 1;
    policy.info.most_command = 2.0;
    policy.info.shield_band = 1e6;  // so that it always has to act
    policy.info.shield_cone = 1e-3;
    export_policy(policy, export_format_from("header"), {HeaderPrecision::float32}, stem + ".h");
    export_policy(policy, export_format_from("header"), {HeaderPrecision::float64}, stem + "_double.h");
    export_policy(policy, export_format_from("torchscript"), {}, stem + ".pt");
  }
  return 0;
}
