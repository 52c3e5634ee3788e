// The source of the dense kernels, included once per instruction set with
//   S2NNDS_KERNEL_SPACE  the namespace,
//   S2NNDS_VECTOR_BYTES  the register width,
//   S2NNDS_WIDE_ROWS     rows a block when it is four registers wide.
// It uses GCC's vector extensions and nothing that other files might also instantiate, so that no instruction
// of a newer processor leaks into the rest of the program.

#include <cmath>
#include <cstdint>
#include <cstring>

#include "s2nnds/networks/dense_kernels.h"

namespace s2nnds::S2NNDS_KERNEL_SPACE {
namespace {

using std::ptrdiff_t;

template <typename T>
struct Simd;
template <>
struct Simd<float> {
  typedef float Vector __attribute__((vector_size(S2NNDS_VECTOR_BYTES)));
  typedef std::int32_t Integers __attribute__((vector_size(S2NNDS_VECTOR_BYTES)));
  static constexpr float round_magic = 12582912.0F;  // 1.5 * 2^23: adding it rounds to an integer
  static constexpr std::int32_t bias = 127, mantissa = 23;
  static constexpr float ln2_high = 0.693359375F, ln2_low = -2.12194440e-4F;
  static constexpr float exp_floor = -87.0F, tanh_ceiling = 10.0F;
  static constexpr int terms = 7;  // of the Taylor series of expm1 on |r| <= ln(2) / 2
};
template <>
struct Simd<double> {
  typedef double Vector __attribute__((vector_size(S2NNDS_VECTOR_BYTES)));
  typedef std::int64_t Integers __attribute__((vector_size(S2NNDS_VECTOR_BYTES)));
  static constexpr double round_magic = 6755399441055744.0;  // 1.5 * 2^52
  static constexpr std::int64_t bias = 1023, mantissa = 52;
  static constexpr double ln2_high = 6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10;
  static constexpr double exp_floor = -708.0, tanh_ceiling = 22.0;
  static constexpr int terms = 13;
};

template <typename T>
using VectorOf = typename Simd<T>::Vector;

template <typename T>
inline VectorOf<T> load(const T* from) {
  VectorOf<T> v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <typename T>
inline void store(T* to, VectorOf<T> v) {
  std::memcpy(to, &v, sizeof v);
}

template <typename T, int Rows, int Registers>
void block(ptrdiff_t depth, const T* a, ptrdiff_t a_row, ptrdiff_t a_column, const T* b, ptrdiff_t b_row,
           T* c, ptrdiff_t c_row, bool accumulate) {
  constexpr ptrdiff_t lanes = S2NNDS_VECTOR_BYTES / sizeof(T);
  VectorOf<T> sum[Rows][Registers];
  for (int m = 0; m < Rows; ++m) {
    for (int j = 0; j < Registers; ++j) {
      sum[m][j] = accumulate ? load(c + m * c_row + j * lanes) : VectorOf<T>{};
    }
  }
  for (ptrdiff_t k = 0; k < depth; ++k) {
    VectorOf<T> right[Registers];
    for (int j = 0; j < Registers; ++j) right[j] = load(b + k * b_row + j * lanes);
    for (int m = 0; m < Rows; ++m) {
      const T left = a[m * a_row + k * a_column];
      for (int j = 0; j < Registers; ++j) sum[m][j] += left * right[j];
    }
  }
  for (int m = 0; m < Rows; ++m) {
    for (int j = 0; j < Registers; ++j) store(c + m * c_row + j * lanes, sum[m][j]);
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
  constexpr ptrdiff_t lanes = S2NNDS_VECTOR_BYTES / sizeof(T);
  ptrdiff_t n = 0;
  for (; n + 4 * lanes <= columns; n += 4 * lanes) {
    strip<T, S2NNDS_WIDE_ROWS, 4>(rows, depth, a, a_row, a_column, b + n, b_row, c + n, c_row, accumulate);
  }
  for (; n + 2 * lanes <= columns; n += 2 * lanes) {
    strip<T, 2 * S2NNDS_WIDE_ROWS, 2>(rows, depth, a, a_row, a_column, b + n, b_row, c + n, c_row,
                                      accumulate);
  }
  for (; n < columns; n += lanes) {
    strip<T, 2 * S2NNDS_WIDE_ROWS, 1>(rows, depth, a, a_row, a_column, b + n, b_row, c + n, c_row,
                                      accumulate);
  }
}

template <typename T>
inline VectorOf<T> choose(typename Simd<T>::Integers where, VectorOf<T> yes, VectorOf<T> no) {
  return where ? yes : no;
}
template <typename T>
inline VectorOf<T> magnitude(VectorOf<T> x) {
  return choose<T>(x < T(0), -x, x);
}

template <typename T>
constexpr T reciprocal_factorial(int k) {
  double factorial = 1.0;
  for (int i = 2; i <= k; ++i) factorial *= i;
  return static_cast<T>(1.0 / factorial);
}

// exp(x) and exp(x) - 1 for x <= 0, by x = n ln 2 + r. NaN stays NaN.
template <typename T>
inline void exp_of_negative(VectorOf<T> x, VectorOf<T>& exp, VectorOf<T>& expm1) {
  using S = Simd<T>;
  using Integers = typename S::Integers;
  x = choose<T>(x < S::exp_floor, VectorOf<T>{} + S::exp_floor, x);
  const VectorOf<T> n = (x * T(1.4426950408889634) + S::round_magic) - S::round_magic;
  const VectorOf<T> r = (x - n * S::ln2_high) - n * S::ln2_low;
  VectorOf<T> tail = VectorOf<T>{} + reciprocal_factorial<T>(S::terms);  // of (exp(r) - 1) / r, Horner
  for (int k = S::terms - 1; k >= 1; --k) tail = tail * r + reciprocal_factorial<T>(k);
  const VectorOf<T> small = tail * r;
  const Integers exponent = (__builtin_convertvector(n, Integers) + S::bias) << S::mantissa;
  VectorOf<T> power;
  std::memcpy(&power, &exponent, sizeof power);
  power = choose<T>(x == x, power, x);
  expm1 = power * small + (power - T(1));
  exp = power * small + power;
}

template <typename T>
inline void logistic(VectorOf<T> x, VectorOf<T>& s, VectorOf<T>& complement) {
  VectorOf<T> e, unused;
  exp_of_negative<T>(-magnitude<T>(x), e, unused);
  const VectorOf<T> large = T(1) / (T(1) + e), small = e / (T(1) + e);
  s = choose<T>(x < T(0), small, large);
  complement = choose<T>(x < T(0), large, small);
}

template <typename T>
struct Derivatives {
  VectorOf<T> value, first, second;
};

template <typename T>
inline Derivatives<T> tanh_of(VectorOf<T> z) {
  VectorOf<T> x = magnitude<T>(z);
  x = choose<T>(x > Simd<T>::tanh_ceiling, VectorOf<T>{} + Simd<T>::tanh_ceiling, x);
  VectorOf<T> unused, t;
  exp_of_negative<T>(T(-2) * x, unused, t);
  VectorOf<T> value = -t / (T(2) + t);
  value = choose<T>(z < T(0), -value, value);
  const VectorOf<T> first = T(1) - value * value;
  return {value, first, T(-2) * value * first};
}

template <typename T>
inline Derivatives<T> elu_of(VectorOf<T> z) {
  VectorOf<T> e, em1;
  exp_of_negative<T>(choose<T>(z > T(0), VectorOf<T>{}, z), e, em1);
  const VectorOf<T> one = VectorOf<T>{} + T(1);
  return {choose<T>(z > T(0), z, em1), choose<T>(z > T(0), one, e), choose<T>(z > T(0), VectorOf<T>{}, e)};
}

template <typename T>
inline Derivatives<T> silu_of(VectorOf<T> z) {
  VectorOf<T> s, c;
  logistic<T>(z, s, c);
  return {z * s, s * (T(1) + z * c), s * c * (T(2) + z * (c - s))};
}

template <typename T>
inline Derivatives<T> softplus_of(VectorOf<T> z) {
  VectorOf<T> s, c;
  logistic<T>(z, s, c);
  constexpr int lanes = S2NNDS_VECTOR_BYTES / sizeof(T);
  VectorOf<T> value = z;
  for (int i = 0; i < lanes; ++i)
    value[i] = std::log1p(std::exp(z[i] > 0 ? -z[i] : z[i])) + (z[i] > 0 ? z[i] : T(0));
  return {choose<T>(z == z, value, z), s, s * c};
}

template <typename T>
inline Derivatives<T> sine_of(VectorOf<T> z) {
  constexpr int lanes = S2NNDS_VECTOR_BYTES / sizeof(T);
  VectorOf<T> s = z, c = z;
  for (int i = 0; i < lanes; ++i) {
    s[i] = std::sin(z[i]);
    c[i] = std::cos(z[i]);
  }
  return {s, c, -s};
}

template <typename T>
inline Derivatives<T> identity_of(VectorOf<T> z) {
  return {z, VectorOf<T>{} + T(1), VectorOf<T>{}};
}

template <typename T, Derivatives<T> (*Of)(VectorOf<T>)>
void apply(ptrdiff_t count, const T* z, T* value, T* first, T* second) {
  constexpr ptrdiff_t lanes = S2NNDS_VECTOR_BYTES / sizeof(T);
  for (ptrdiff_t i = 0; i < count; i += lanes) {
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
  constexpr ptrdiff_t lanes = S2NNDS_VECTOR_BYTES / sizeof(T);
  for (ptrdiff_t i = 0; i < count; i += lanes) {
    const VectorOf<T> d = load(dz + i);
    store(tangent + i, load(slope + i) * d);
    if (curve) store(curve + i, load(curve + i) * d);
  }
}

template <typename T>
void pull_adjoint(ptrdiff_t count, const T* slope, const T* curve, T* adjoint, T* adjoint_tangent) {
  constexpr ptrdiff_t lanes = S2NNDS_VECTOR_BYTES / sizeof(T);
  for (ptrdiff_t i = 0; i < count; i += lanes) {
    const VectorOf<T> s = load(slope + i);
    VectorOf<T> a = load(adjoint + i) * s;
    if (adjoint_tangent) {
      const VectorOf<T> t = load(adjoint_tangent + i);
      a += t * load(curve + i);
      store(adjoint_tangent + i, t * s);
    }
    store(adjoint + i, a);
  }
}

}  // namespace

extern const DenseKernels<float> float_kernels = {S2NNDS_KERNEL_NAME, multiply<float>, activate<float>,
                                                  push_tangent<float>, pull_adjoint<float>};
extern const DenseKernels<double> double_kernels = {S2NNDS_KERNEL_NAME, multiply<double>, activate<double>,
                                                    push_tangent<double>, pull_adjoint<double>};

}  // namespace s2nnds::S2NNDS_KERNEL_SPACE
