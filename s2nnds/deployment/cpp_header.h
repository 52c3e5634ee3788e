#pragma once

#include <string>
#include <string_view>

#include "s2nnds/deployment/policy_info.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// What the exported header computes f in.
enum class HeaderPrecision {
  float32,  // fastest; its error is bounded by PolicyInfo::float32_error, which the certificate compares with
            // its margin
  float64,  // the certified function up to some 1e-14
};
HeaderPrecision header_precision_from(std::string_view name);  // "float", "double"; throws Error

// "policy_" and the name of the file without its extension, what is no letter or digit replaced by "_".
std::string policy_namespace(const std::string& path);

// Writes the policy as one C++17 header for control loops: no dependency but the standard library, no
// allocation, no exception, no global state but constants. In namespace policy_namespace(path):
//   velocity(x, v), lyapunov(x), barrier(x), safe(x) with x [n] a position in the data's unit, goal-centred,
//   and v [n] in that unit per second: what the methods of the TorchScript policy compute. NaN in gives NaN
//   (and not safe) out. V and B are computed in double whatever the precision, so that `safe` decides as the
//   certified barrier does but for rounding in double (some 1e-14 of B). Constants dimension, position_scale,
//   velocity_scale, name, unit, guarantee, statement, weight_hash, workspace [2 n] (lower corner, then upper
//   corner, data's unit), precision, disturbance_margin and float32_error (unit per second).
// Loops are written for the vector registers of GCC and Clang (SSE2 to AVX-512, NEON) as the flags allow, and
// run one by one elsewhere. f(0) = 0 exactly for zero_at_origin networks. The file is written beside `path` and
// renamed. Throws Error if it cannot be written, or if the networks do not fit.
void export_cpp_header(const Networks& networks, const PolicyInfo& info, HeaderPrecision precision,
                       const std::string& path);

}  // namespace s2nnds
