// SPDX-License-Identifier: BSD-3-Clause
#define S2NNDS_KERNEL_SPACE avx2
#define SIMD_REGISTER_BYTES 32
#include "s2nnds/verification/taylor_kernels.inl"
