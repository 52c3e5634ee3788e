#if defined(__AVX2__) && defined(__FMA__)
#define S2NNDS_KERNEL_SPACE avx2
#define S2NNDS_KERNEL_NAME "avx2"
#define S2NNDS_VECTOR_BYTES 32
#define S2NNDS_WIDE_ROWS 3
#include "s2nnds/networks/dense_kernels.inl"
#endif
