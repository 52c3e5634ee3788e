// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/deployment/policy.h"

namespace s2nnds {

// The bytes of a program of torch.export (loads with torch.export.load):
// - argument: `position` [N, n] float32 or float64, N >= 0, in the data's unit and frame;
// - result: a dict of `velocity` [N, n] in that unit per second, `lyapunov` [N], `barrier` [N], computed in
//   float64, and `safe` [N] bool, B <= 0 and inside the workspace;
// - extra file `policy.json`: every field of PolicyInfo by its name; a number that is not finite is null.
//
// PyTorch writes this format from Python only: the Python that the environment variable S2NNDS_PYTHON names,
// else /usr/bin/python3, runs pt2_writer.py, which takes some seconds. Throws Error if it cannot be started,
// has no torch that is new enough, or torch refuses the policy.
std::string pt2_program(const Policy& policy);

}  // namespace s2nnds
