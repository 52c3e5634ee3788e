// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "s2nnds/deployment/policy.h"
#include "s2nnds/runs/scene_range.h"

namespace s2nnds {

// What the exported header computes f in.
enum class HeaderPrecision {
  // Fastest; PolicyInfo::float32_error bounds its error, and the certificate compares that with its margin.
  float32,
  float64,  // the certified function up to some 1e-14
};
// "float" or "double"; throws Error on another name.
HeaderPrecision header_precision_from(std::string_view name);

// "policy_" and the name of the file without its extension; what is no letter or digit becomes "_".
std::string policy_namespace(const std::string& path);

// The policy as one C++17 header for control loops: no dependency but the standard library, no allocation, no
// exception, no global state but constants. In the namespace `space`:
// - `velocity(x, v)`, `lyapunov(x)`, `barrier(x)`, `safe(x)`, `in_workspace(x)` with x [n] a position in the data's unit
//   and frame, and v [n] in that unit per second: f, V, B and {B <= 0} within the workspace. NaN
//   in gives NaN (and not safe) out. V and B are computed in double whatever the precision, so that `safe`
//   decides as the certified barrier does but for rounding in double (some 1e-14 of B);
// - `velocity(x, q, v, omega)` where poses move: v as above, and omega [3] the angular velocity in rad/s in the frame of
//   the data (q' = 1/2 (0, omega) q) at the orientation q [4] in the order `quaternion_order`, in double;
// - `shield(x, v_wanted, v)`, if PolicyInfo::shielded: any other velocity made safe, by verification/executed_motion.h;
// - with a range of scenes `velocity(x, p, v)`, `velocity(x, p, rate, v)` (of poses `velocity(x, q, p, rate, v, omega)`),
//   `lyapunov(x, p)`, `barrier(x, p)`, `safe(x, p)` and `displaced(p)`, of an obstacle displaced by p (displaced_source.h);
// - `Motion`, the type that PassiveController (passive_controller.h) takes;
// - constants: `precision` and every field of PolicyInfo.
//
// Loops are written for the vector registers of GCC and Clang (SSE2 to AVX-512, NEON) as the flags allow, and
// run one by one elsewhere. The velocity at the goal is 0 exactly for zero_at_origin networks. Throws Error if a weight of f is
// beyond the precision's range.
std::string cpp_header(const Policy& policy, HeaderPrecision precision, const std::string& space,
                       const std::optional<SceneRange>& range = std::nullopt);

}  // namespace s2nnds
