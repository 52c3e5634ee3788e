// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "s2nnds/networks/activation.h"

namespace s2nnds {

// Layers are padded to a multiple of this many neurons.
inline constexpr std::ptrdiff_t kLanePadding = 16;
// `width` rounded up to a multiple of kLanePadding.
inline std::ptrdiff_t padded(std::ptrdiff_t width) {
  return (width + kLanePadding - 1) / kLanePadding * kLanePadding;
}

// The inner loops of all networks in precision T (float, double), compiled once per InstructionSet and chosen
// at run time. Rows are samples, columns are neurons padded to a multiple of kLanePadding, so that every
// product of the forward and the reverse sweep has contiguous columns and needs no transposition of
// activations.
template <typename T>
struct DenseKernels {
  // C[m, n] = (accumulate ? C : 0) + sum_k A(m, k) B[k, n] for m < rows, n < columns (a multiple of
  // kLanePadding), A(m, k) = a[m * a_row + k * a_column]. The sum runs over k in order, whatever the
  // blocking: a row's result does not depend on the rows beside it.
  void (*multiply)(std::ptrdiff_t rows, std::ptrdiff_t columns, std::ptrdiff_t depth, const T* a,
                   std::ptrdiff_t a_row, std::ptrdiff_t a_column, const T* b, std::ptrdiff_t b_row, T* c,
                   std::ptrdiff_t c_row, bool accumulate);
  // value = sigma(z) and, where the pointers are not null, first = sigma'(z), second = sigma''(z); count is a
  // multiple of kLanePadding. In double, values are within 4e-15 * max(1, |value|) of the exact ones.
  void (*activate)(Activation activation, std::ptrdiff_t count, const T* z, T* value, T* first, T* second);
  // The tangent through an activation: tangent = slope * dz and, unless null, curve *= dz.
  void (*push_tangent)(std::ptrdiff_t count, const T* slope, const T* dz, T* tangent, T* curve);
  // The adjoints through an activation: adjoint = adjoint * slope + adjoint_tangent * curve,
  // adjoint_tangent *= slope; the value's alone where adjoint_tangent is null.
  void (*pull_adjoint)(std::ptrdiff_t count, const T* slope, const T* curve, T* adjoint, T* adjoint_tangent);
};

// The kernels for instruction_set().
template <typename T>
const DenseKernels<T>& dense_kernels();

}  // namespace s2nnds
