// SPDX-License-Identifier: BSD-3-Clause
#define S2NNDS_KERNEL_SPACE avx2
#define SIMD_REGISTER_BYTES 32
#define S2NNDS_WIDE_ROWS 3
#include "s2nnds/networks/dense_kernels.inl"
