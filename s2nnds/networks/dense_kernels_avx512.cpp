#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define S2NNDS_KERNEL_SPACE avx512
#define S2NNDS_KERNEL_NAME "avx512"
#define S2NNDS_VECTOR_BYTES 64
#define S2NNDS_WIDE_ROWS 6
#include "s2nnds/networks/dense_kernels.inl"
#endif
