#pragma once

namespace s2nnds {

// The part of an exported C++ header that is the same for every policy: dense layers and activations as C++17
// source text, to stand inside the policy's namespace `detail`. It needs <cfloat>, <cmath>, <cstdint>,
// <cstring> and <utility>. Against exact arithmetic its activations are wrong by at most 3 units in the last
// place (of 1, where they are bounded), which float32_error() (verification/disturbance_margin.h) covers with
// its 8.
extern const char* const policy_kernels_source;

}  // namespace s2nnds
