#include <math.h>
#include <string.h>

#include "s2nnds/verification/taylor_kernels.h"

#define S2NNDS_TAYLOR_SPACE taylor_plain
#define S2NNDS_TAYLOR_LANES 2
#include "s2nnds/verification/taylor_kernels.inl"
