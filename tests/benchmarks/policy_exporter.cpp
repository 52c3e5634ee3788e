// Writes the policy that the evaluation benchmarks run, f of 2-WIDTH-WIDTH-WIDTH-2 with random weights, as a
// header and as TorchScript: FOLDER/width_WIDTH.h and .pt. Run by the build. Usage: policy_exporter FOLDER
// WIDTH...
#include <string>

#include "s2nnds/deployment/cpp_header.h"
#include "s2nnds/deployment/torchscript.h"
#include "work.h"

int main(int argc, char** argv) {
  using namespace s2nnds;
  for (int k = 2; k < argc; ++k) {
    const std::string stem = std::string(argv[1]) + "/width_" + argv[k];
    NetworkOptions options;
    options.f.network.hidden.assign(3, std::stol(argv[k]));
    RandomStream random(0, "evaluation");
    const Networks networks = {VectorField(2, options.f, random)->snapshot(),
                               Lyapunov(2, options.V, random)->snapshot(),
                               Barrier(2, options.B, random)->snapshot()};
    PolicyInfo info;
    info.name = "benchmark";
    info.guarantee = "none";
    info.workspace_lower = Vector::Constant(2, -1.25);
    info.workspace_upper = Vector::Constant(2, 1.25);
    export_cpp_header(networks, info, HeaderPrecision::float32, stem + ".h");
    export_cpp_header(networks, info, HeaderPrecision::float64, stem + "_double.h");
    export_torchscript(networks, info, stem + ".pt");
  }
  return 0;
}
