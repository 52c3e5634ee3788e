// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/deployment/policy.h"

namespace s2nnds {

// The bytes of a TorchScript module (loads with torch.jit.load and torch::jit::load; PyTorch deprecates the
// format, see pt2.h):
// - `forward(x)`: velocities [N, n] in the data's unit per second, at positions x [N, n] in the data's unit and
//   frame;
// - `lyapunov(x)`, `barrier(x)`: [N];
// - `safe(x)`: [N] bool, B <= 0 and inside the workspace;
// - every field of PolicyInfo as an attribute.
//
// The goal is subtracted in double; positions that come in float32 have lost digits before, the more the farther they
// are from the origin. Weights are float32, as they were trained; module.double() evaluates in double. Throws Error if a weight is
// beyond float's range.
std::string torchscript_module(const Policy& policy);

}  // namespace s2nnds
