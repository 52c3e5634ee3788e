// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/deployment/policy.h"

namespace s2nnds {

// The bytes of an ONNX model (IR 7, operators of set 13):
// - input: `position` [N, n] double, in the data's unit and frame;
// - outputs, double: `velocity` [N, n] in that unit per second, `lyapunov` [N], `barrier` [N];
// - where poses move, also the input `orientation` [N, 4] double, in the order `quaternion_order`, and the output
//   `angular_velocity` [N, 3] double, rad/s in the frame of the data, both computed in double but for an arc tangent;
// - metadata: every field of PolicyInfo by its name; lists are separated by ", ".
//
// A position is safe where barrier <= 0 and it lies in the workspace. Weights are float32, as they were
// trained, and so is what lies between the positions seen from the goal and the velocities. Throws Error if a weight is beyond float's range.
std::string onnx_model(const Policy& policy);

}  // namespace s2nnds
