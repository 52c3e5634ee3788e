#pragma once

#include <string>

#include "s2nnds/deployment/policy_info.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// Writes an ONNX model (IR 7, operators of set 13):
//   input  position [N, n] float, in the data's unit, goal-centred
//   output velocity [N, n] in that unit per second, lyapunov [N], barrier [N]
// and as metadata name, unit, guarantee, statement, weight_hash, dimension, position_scale, velocity_scale
// and workspace (lower corner, then upper corner, in the data's unit). A position is safe where barrier <= 0
// and it lies in the workspace. Weights are float32, as they were trained. The file is written beside `path`
// and renamed. Throws Error if it cannot be written.
void export_onnx(const Networks& networks, const PolicyInfo& info, const std::string& path);

}  // namespace s2nnds
