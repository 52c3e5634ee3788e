// SPDX-License-Identifier: BSD-3-Clause
#define S2NNDS_KERNEL_SPACE plain
#define SIMD_REGISTER_BYTES 16
#include "s2nnds/verification/taylor_kernels.inl"
