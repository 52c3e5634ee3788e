// SPDX-License-Identifier: BSD-3-Clause
// The source of the dense kernels, included once per instruction set with
//   S2NNDS_KERNEL_SPACE  the namespace
//   SIMD_REGISTER_BYTES  the register width
//   S2NNDS_WIDE_ROWS     rows a block when it is four registers wide
// It uses GCC's vector extensions and nothing that other files might also instantiate, so that no instruction
// of a newer processor leaks into the rest of the program.

#include <cmath>
#include <cstdint>
#include <cstring>

#include "s2nnds/networks/dense_kernels.h"

namespace s2nnds::S2NNDS_KERNEL_SPACE {
namespace {

using std::ptrdiff_t;

#include "s2nnds/networks/simd_exponential.inl"

template <typename T, int Rows, int Registers>
void block(ptrdiff_t depth, const T* a, ptrdiff_t a_row, ptrdiff_t a_column, const T* b, ptrdiff_t b_row,
           T* c, ptrdiff_t c_row, bool accumulate) {
  PackOf<T> sum[Rows][Registers];
  for (int m = 0; m < Rows; ++m) {
    for (int j = 0; j < Registers; ++j) {
      sum[m][j] = accumulate ? load(c + m * c_row + j * lanes<T>) : PackOf<T>{};
    }
  }
  for (ptrdiff_t k = 0; k < depth; ++k) {
    PackOf<T> right[Registers];
    for (int j = 0; j < Registers; ++j) right[j] = load(b + k * b_row + j * lanes<T>);
    for (int m = 0; m < Rows; ++m) {
      const T left = a[m * a_row + k * a_column];
      for (int j = 0; j < Registers; ++j) sum[m][j] += left * right[j];
    }
  }
  for (int m = 0; m < Rows; ++m) {
    for (int j = 0; j < Registers; ++j) store(c + m * c_row + j * lanes<T>, sum[m][j]);
  }
}

// All rows of one strip of columns, in blocks of Rows, then one by one.
template <typename T, int Rows, int Registers>
void strip(ptrdiff_t rows, ptrdiff_t depth, const T* a, ptrdiff_t a_row, ptrdiff_t a_column, const T* b,
           ptrdiff_t b_row, T* c, ptrdiff_t c_row, bool accumulate) {
  ptrdiff_t m = 0;
  for (; m + Rows <= rows; m += Rows) {
    block<T, Rows, Registers>(depth, a + m * a_row, a_row, a_column, b, b_row, c + m * c_row, c_row,
                              accumulate);
  }
  if constexpr (Rows > 1) {
    strip<T, (Rows > 4 ? 4 : Rows / 2), Registers>(rows - m, depth, a + m * a_row, a_row, a_column, b, b_row,
                                                   c + m * c_row, c_row, accumulate);
  }
}

template <typename T>
void multiply(ptrdiff_t rows, ptrdiff_t columns, ptrdiff_t depth, const T* a, ptrdiff_t a_row,
              ptrdiff_t a_column, const T* b, ptrdiff_t b_row, T* c, ptrdiff_t c_row, bool accumulate) {
  ptrdiff_t n = 0;
  for (; n + 4 * lanes<T> <= columns; n += 4 * lanes<T>) {
    strip<T, S2NNDS_WIDE_ROWS, 4>(rows, depth, a, a_row, a_column, b + n, b_row, c + n, c_row, accumulate);
  }
  for (; n + 2 * lanes<T> <= columns; n += 2 * lanes<T>) {
    strip<T, 2 * S2NNDS_WIDE_ROWS, 2>(rows, depth, a, a_row, a_column, b + n, b_row, c + n, c_row,
                                      accumulate);
  }
  for (; n < columns; n += lanes<T>) {
    strip<T, 2 * S2NNDS_WIDE_ROWS, 1>(rows, depth, a, a_row, a_column, b + n, b_row, c + n, c_row,
                                      accumulate);
  }
}

template <typename T>
inline PackOf<T> magnitude(PackOf<T> x) {
  return x < T(0) ? -x : x;
}

template <typename T>
inline void logistic(PackOf<T> x, PackOf<T>& s, PackOf<T>& complement) {
  PackOf<T> e, unused;
  exp_of_negative<T>(-magnitude<T>(x), e, unused);
  const PackOf<T> large = T(1) / (T(1) + e), small = e / (T(1) + e);
  s = x < T(0) ? small : large;
  complement = x < T(0) ? large : small;
}

template <typename T>
struct Derivatives {
  PackOf<T> value, first, second;
};

template <typename T>
inline Derivatives<T> tanh_of(PackOf<T> z) {
  PackOf<T> x = magnitude<T>(z);
  x = x > Simd<T>::tanh_ceiling ? PackOf<T>{} + Simd<T>::tanh_ceiling : x;
  PackOf<T> unused, t;
  exp_of_negative<T>(T(-2) * x, unused, t);
  PackOf<T> value = -t / (T(2) + t);
  value = z < T(0) ? -value : value;
  const PackOf<T> first = T(1) - value * value;
  return {value, first, T(-2) * value * first};
}

template <typename T>
inline Derivatives<T> elu_of(PackOf<T> z) {
  PackOf<T> e, em1;
  exp_of_negative<T>(z > T(0) ? PackOf<T>{} : z, e, em1);
  const PackOf<T> one = PackOf<T>{} + T(1);
  return {z > T(0) ? z : em1, z > T(0) ? one : e, z > T(0) ? PackOf<T>{} : e};
}

template <typename T>
inline Derivatives<T> silu_of(PackOf<T> z) {
  PackOf<T> s, c;
  logistic<T>(z, s, c);
  return {z * s, s * (T(1) + z * c), s * c * (T(2) + z * (c - s))};
}

template <typename T>
inline Derivatives<T> softplus_of(PackOf<T> z) {
  PackOf<T> s, c;
  logistic<T>(z, s, c);
  PackOf<T> value = z;
  for (int i = 0; i < lanes<T>; ++i)
    value[i] = std::log1p(std::exp(z[i] > 0 ? -z[i] : z[i])) + (z[i] > 0 ? z[i] : T(0));
  return {z == z ? value : z, s, s * c};
}

template <typename T>
inline Derivatives<T> sine_of(PackOf<T> z) {
  PackOf<T> s = z, c = z;
  for (int i = 0; i < lanes<T>; ++i) {
    s[i] = std::sin(z[i]);
    c[i] = std::cos(z[i]);
  }
  return {s, c, -s};
}

template <typename T>
inline Derivatives<T> identity_of(PackOf<T> z) {
  return {z, PackOf<T>{} + T(1), PackOf<T>{}};
}

template <typename T, Derivatives<T> (*Of)(PackOf<T>)>
void apply(ptrdiff_t count, const T* z, T* value, T* first, T* second) {
  for (ptrdiff_t i = 0; i < count; i += lanes<T>) {
    const Derivatives<T> d = Of(load(z + i));
    store(value + i, d.value);
    if (first) store(first + i, d.first);
    if (second) store(second + i, d.second);
  }
}

template <typename T>
void activate(Activation activation, ptrdiff_t count, const T* z, T* value, T* first, T* second) {
  switch (activation) {
    case Activation::identity:
      return apply<T, identity_of<T>>(count, z, value, first, second);
    case Activation::tanh:
      return apply<T, tanh_of<T>>(count, z, value, first, second);
    case Activation::elu:
      return apply<T, elu_of<T>>(count, z, value, first, second);
    case Activation::softplus:
      return apply<T, softplus_of<T>>(count, z, value, first, second);
    case Activation::silu:
      return apply<T, silu_of<T>>(count, z, value, first, second);
    case Activation::sine:
      return apply<T, sine_of<T>>(count, z, value, first, second);
  }
}

template <typename T>
void push_tangent(ptrdiff_t count, const T* slope, const T* dz, T* tangent, T* curve) {
  for (ptrdiff_t i = 0; i < count; i += lanes<T>) {
    const PackOf<T> d = load(dz + i);
    store(tangent + i, load(slope + i) * d);
    if (curve) store(curve + i, load(curve + i) * d);
  }
}

template <typename T>
void pull_adjoint(ptrdiff_t count, const T* slope, const T* curve, T* adjoint, T* adjoint_tangent) {
  for (ptrdiff_t i = 0; i < count; i += lanes<T>) {
    const PackOf<T> s = load(slope + i);
    PackOf<T> a = load(adjoint + i) * s;
    if (adjoint_tangent) {
      const PackOf<T> t = load(adjoint_tangent + i);
      a += t * load(curve + i);
      store(adjoint_tangent + i, t * s);
    }
    store(adjoint + i, a);
  }
}

}  // namespace

extern const DenseKernels<float> float_kernels = {multiply<float>, activate<float>, push_tangent<float>,
                                                  pull_adjoint<float>};
extern const DenseKernels<double> double_kernels = {multiply<double>, activate<double>, push_tangent<double>,
                                                    pull_adjoint<double>};

}  // namespace s2nnds::S2NNDS_KERNEL_SPACE
