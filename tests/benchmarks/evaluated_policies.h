// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace s2nnds::benchmarks {

// The exported headers of f (2-WIDTH-WIDTH-WIDTH-2) that policy_exporter writes during the build.
using Velocity = void (*)(const double* x, double* v) noexcept;
Velocity float_policy(int width);  // 32, 64, 128 or 256; null for others
Velocity double_policy(int width);

// The shield of the policy in float of width 64, as at the edge of the safe set.
double shielded_velocity(const double* x, const double* wanted, double* v) noexcept;

}  // namespace s2nnds::benchmarks
