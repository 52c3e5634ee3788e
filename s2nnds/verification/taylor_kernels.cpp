// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/taylor_kernels.h"

#include "s2nnds/networks/instruction_set.h"

namespace s2nnds {

namespace plain {
extern const TaylorKernels taylor_kernels;
}
namespace avx2 {
extern const TaylorKernels taylor_kernels;
}
namespace avx512 {
extern const TaylorKernels taylor_kernels;
}

const TaylorKernels& taylor_kernels() {
  return kernels_here(plain::taylor_kernels, avx2::taylor_kernels, avx512::taylor_kernels);
}

}  // namespace s2nnds
