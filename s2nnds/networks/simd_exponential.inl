// SPDX-License-Identifier: BSD-3-Clause
// Packs of numbers, one a vector register, and exp on them. Included inside a namespace, once for each width
// of registers, and part of every exported C++ header: it uses nothing but <cfloat>, <cmath>, <cstdint> and
// <cstring>, and SIMD_REGISTER_BYTES, the width; 0: no vector types, a pack is one number.

template <typename Real, typename Word>
struct Registers {
#if SIMD_REGISTER_BYTES > 0
  typedef Real Pack __attribute__((vector_size(SIMD_REGISTER_BYTES)));
  typedef Word Bits __attribute__((vector_size(SIMD_REGISTER_BYTES)));
#else
  typedef Real Pack;
  typedef Word Bits;
#endif
};
template <typename Real>
struct Simd;
template <>
struct Simd<float> : Registers<float, std::uint32_t> {
  static constexpr float magic = 12582912.0F;  // 1.5 * 2^23: adding it rounds to an integer
  static constexpr std::uint32_t one = 0x3f800000U;
  static constexpr int mantissa = 23, terms = 7;
  static constexpr float ln2_high = 0.693359375F, ln2_low = -2.12194440e-4F;
  static constexpr float exp_floor = -87.0F, tanh_ceiling = 10.0F;
};
template <>
struct Simd<double> : Registers<double, std::uint64_t> {
  static constexpr double magic = 6755399441055744.0;  // 1.5 * 2^52
  static constexpr std::uint64_t one = 0x3ff0000000000000U;
  static constexpr int mantissa = 52, terms = 13;
  static constexpr double ln2_high = 6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10;
  static constexpr double exp_floor = -708.0, tanh_ceiling = 22.0;
};

template <typename Real>
using PackOf = typename Simd<Real>::Pack;
template <typename Real>
constexpr int lanes = static_cast<int>(sizeof(PackOf<Real>) / sizeof(Real));

template <typename Real>
inline PackOf<Real> load(const Real* from) noexcept {
  PackOf<Real> pack;
  std::memcpy(&pack, from, sizeof pack);
  return pack;
}
template <typename Real>
inline void store(Real* to, const PackOf<Real>& pack) noexcept {
  std::memcpy(to, &pack, sizeof pack);
}

template <typename Real>
constexpr Real reciprocal_factorial(int k) noexcept {
  double factorial = 1.0;
  for (int i = 2; i <= k; ++i) factorial *= i;
  return static_cast<Real>(1.0 / factorial);
}

// (exp(r) - 1) / r by its Taylor series, for |r| <= ln(2) / 2.
template <typename Real, int Term = 1>
inline void expm1_series(const PackOf<Real>& r, PackOf<Real>& sum) noexcept {
  if constexpr (Term == Simd<Real>::terms) {
    sum = PackOf<Real>{} + reciprocal_factorial<Real>(Term);
  } else {
    expm1_series<Real, Term + 1>(r, sum);
    sum = sum * r + reciprocal_factorial<Real>(Term);
  }
}

// exp(x) = power (1 + series r) for x <= 0, by x = n ln 2 + r and power = 2^n. NaN makes r and series NaN.
template <typename Real>
inline void split_exponential(PackOf<Real> x, PackOf<Real>& power, PackOf<Real>& series,
                              PackOf<Real>& r) noexcept {
  using S = Simd<Real>;
  x = x < S::exp_floor ? PackOf<Real>{} + S::exp_floor : x;
  const PackOf<Real> shifted = x * Real(1.4426950408889634) + S::magic;
  const PackOf<Real> n = shifted - S::magic;
  r = (x - n * S::ln2_high) - n * S::ln2_low;
  typename S::Bits bits;
  std::memcpy(&bits, &shifted, sizeof bits);
  bits = (bits << S::mantissa) + S::one;  // the low bits of `shifted` are n: this is 2^n
  std::memcpy(&power, &bits, sizeof power);
  expm1_series<Real>(r, series);
}

// exp(x) and exp(x) - 1 for x <= 0. NaN stays NaN.
template <typename Real>
inline void exp_of_negative(const PackOf<Real>& x, PackOf<Real>& exp, PackOf<Real>& expm1) noexcept {
  PackOf<Real> power, series, r;
  split_exponential<Real>(x, power, series, r);
  const PackOf<Real> small = series * r;
  expm1 = power * small + (power - Real(1));
  exp = power * small + power;
}
