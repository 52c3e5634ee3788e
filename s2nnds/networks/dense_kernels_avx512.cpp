// SPDX-License-Identifier: BSD-3-Clause
#define S2NNDS_KERNEL_SPACE avx512
#define SIMD_REGISTER_BYTES 64
#define S2NNDS_WIDE_ROWS 6
#include "s2nnds/networks/dense_kernels.inl"
