#include <math.h>
#include <string.h>

#include "s2nnds/verification/taylor_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC target("avx512f,avx512dq,avx512vl,avx2,fma")
#endif
#define S2NNDS_TAYLOR_SPACE taylor_avx512
#define S2NNDS_TAYLOR_LANES 8
#include "s2nnds/verification/taylor_kernels.inl"
