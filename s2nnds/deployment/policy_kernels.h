// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace s2nnds {

// The texts of networks/simd_exponential.inl and deployment/policy_kernels.inl, which the build puts into the
// program: source that exported C++ headers carry.
extern const char* const simd_exponential_source;
extern const char* const policy_kernels_source;

}  // namespace s2nnds
