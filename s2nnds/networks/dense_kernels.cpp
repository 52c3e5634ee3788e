// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/dense_kernels.h"

#include "s2nnds/networks/instruction_set.h"

namespace s2nnds {

namespace plain {
extern const DenseKernels<float> float_kernels;
extern const DenseKernels<double> double_kernels;
}  // namespace plain
namespace avx2 {
extern const DenseKernels<float> float_kernels;
extern const DenseKernels<double> double_kernels;
}  // namespace avx2
namespace avx512 {
extern const DenseKernels<float> float_kernels;
extern const DenseKernels<double> double_kernels;
}  // namespace avx512

template <>
const DenseKernels<float>& dense_kernels<float>() {
  return kernels_here(plain::float_kernels, avx2::float_kernels, avx512::float_kernels);
}
template <>
const DenseKernels<double>& dense_kernels<double>() {
  return kernels_here(plain::double_kernels, avx2::double_kernels, avx512::double_kernels);
}

}  // namespace s2nnds
