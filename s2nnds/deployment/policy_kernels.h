// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace s2nnds {

// The text of networks/simd_exponential.inl, built into the program: exported C++ headers carry it.
extern const char* const simd_exponential_source;
// The same of deployment/policy_kernels.inl.
extern const char* const policy_kernels_source;

}  // namespace s2nnds
