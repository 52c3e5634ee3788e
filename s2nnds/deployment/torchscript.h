#pragma once

#include <string>

#include "s2nnds/deployment/policy_info.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// Writes a TorchScript module (loads with torch.jit.load and torch::jit::load):
//   forward(x):  positions [N, n] in the data's unit, goal-centred -> velocities [N, n] in that unit per
//   second lyapunov(x), barrier(x) [N] and safe(x) [N] (bool: B <= 0 and inside the workspace) on the same
//   positions attributes position_scale, velocity_scale, unit, dimension, guarantee, statement, weight_hash,
//   name, workspace (lower corner, then upper corner, in the data's unit).
// Weights are float32, as they were trained; module.double() evaluates in double. The file is written beside
// `path` and renamed. Throws Error if it cannot be written.
void export_torchscript(const Networks& networks, const PolicyInfo& info, const std::string& path);

}  // namespace s2nnds
