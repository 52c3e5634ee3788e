// SPDX-License-Identifier: BSD-3-Clause
#define S2NNDS_KERNEL_SPACE plain
#define SIMD_REGISTER_BYTES 16
#define S2NNDS_WIDE_ROWS 2
#include "s2nnds/networks/dense_kernels.inl"
