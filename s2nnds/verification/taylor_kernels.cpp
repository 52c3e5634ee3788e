#include "s2nnds/verification/taylor_kernels.h"

#include <string_view>

#include "s2nnds/networks/dense_kernels.h"

namespace s2nnds {

namespace taylor_plain {
extern const TaylorKernels kernels;
}
namespace taylor_avx2 {
extern const TaylorKernels kernels;
}
namespace taylor_avx512 {
extern const TaylorKernels kernels;
}

const TaylorKernels& taylor_kernels() {
  static const std::string_view set = dense_kernels<double>().instruction_set;
  if (set == "avx512") return taylor_avx512::kernels;
  if (set == "avx2") return taylor_avx2::kernels;
  return taylor_plain::kernels;
}

}  // namespace s2nnds
