// SPDX-License-Identifier: BSD-3-Clause
#define S2NNDS_KERNEL_SPACE avx512
#define SIMD_REGISTER_BYTES 64
#include "s2nnds/verification/taylor_kernels.inl"
