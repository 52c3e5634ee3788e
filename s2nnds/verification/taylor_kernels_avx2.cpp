#include <math.h>
#include <string.h>

#include "s2nnds/verification/taylor_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC target("avx2,fma")
#endif
#define S2NNDS_TAYLOR_SPACE taylor_avx2
#define S2NNDS_TAYLOR_LANES 4
#include "s2nnds/verification/taylor_kernels.inl"
