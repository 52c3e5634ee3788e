#include "s2nnds/deployment/policy_kernels.h"

namespace s2nnds {

const char* const policy_kernels_source = R"cpp(
  // A Pack is as many numbers as one register holds, by the vector types of GCC and Clang; elsewhere it is
  // one number.
#if defined(__GNUC__) && !defined(POLICY_WITHOUT_VECTORS)
#if defined(__AVX512F__)
  constexpr int register_bytes = 64;
#elif defined(__AVX__)
  constexpr int register_bytes = 32;
#else
  constexpr int register_bytes = 16;
#endif
  template <typename Real>
  struct Simd;
  template <>
  struct Simd<float> {
    typedef float Pack __attribute__((vector_size(register_bytes)));
    typedef std::uint32_t Bits __attribute__((vector_size(register_bytes)));
  };
  template <>
  struct Simd<double> {
    typedef double Pack __attribute__((vector_size(register_bytes)));
    typedef std::uint64_t Bits __attribute__((vector_size(register_bytes)));
  };
#else
  template <typename Real>
  struct Simd;
  template <>
  struct Simd<float> {
    using Pack = float;
    using Bits = std::uint32_t;
  };
  template <>
  struct Simd<double> {
    using Pack = double;
    using Bits = std::uint64_t;
  };
#endif

  template <typename Real>
  using PackOf = typename Simd<Real>::Pack;
  template <typename Real>
  constexpr int lanes = static_cast<int>(sizeof(PackOf<Real>) / sizeof(Real));

  template <typename Real>
  inline void load(const Real* from, PackOf<Real>& to) noexcept {
    std::memcpy(&to, from, sizeof to);
  }
  template <typename Real>
  inline void store(const PackOf<Real>& from, Real* to) noexcept {
    std::memcpy(to, &from, sizeof from);
  }

  // sum += w * x
  template <typename Real>
  inline void accumulate(const Real* w, const Real x, PackOf<Real>& sum) noexcept {
    PackOf<Real> weight;
    load<Real>(w, weight);
    sum += weight * x;
  }

  // Some columns of z = w x + bias, w [In][Out], kept in registers over all of x. With few columns, even and
  // odd inputs are summed apart: one chain of additions would wait for itself.
  template <typename Real, int In, int Out, int First, int... J>
  inline void dense_block(const Real* w, const Real* bias, const Real* x, Real* z,
                          std::integer_sequence<int, J...>) noexcept {
    constexpr int count = static_cast<int>(sizeof...(J)), width = lanes<Real>;
    constexpr bool apart = count <= 4 && In > 1;
    PackOf<Real> even[count], odd[count];
    (load<Real>(bias + First + J * width, even[J]), ...);
    ((odd[J] = PackOf<Real>{}), ...);
    int k = 0;
    for (; k + 1 < In; k += 2) {
      const Real* row = w + k * Out + First;
      (accumulate<Real>(row + J * width, x[k], even[J]), ...);
      (accumulate<Real>(row + Out + J * width, x[k + 1], apart ? odd[J] : even[J]), ...);
    }
    if (In % 2 == 1) (accumulate<Real>(w + k * Out + First + J * width, x[k], even[J]), ...);
    if (apart) ((even[J] += odd[J]), ...);
    (store<Real>(even[J], z + First + J * width), ...);
  }

  // z [Out] = w x + bias; Out is a multiple of 16, padded with zeros.
  template <typename Real, int In, int Out, int First = 0>
  inline void dense(const Real* w, const Real* bias, const Real* x, Real* z) noexcept {
    if constexpr (First < Out) {
      constexpr int left = (Out - First) / lanes<Real>, count = left < 8 ? left : 8;
      dense_block<Real, In, Out, First>(w, bias, x, z, std::make_integer_sequence<int, count>());
      dense<Real, In, Out, First + count * lanes<Real>>(w, bias, x, z);
    }
  }

  template <typename Real>
  inline Real sum_of(const PackOf<Real>& pack) noexcept {
    Real lane[static_cast<unsigned>(lanes<Real>)];
    store<Real>(pack, lane);
    Real sum = lane[0];
    for (int i = 1; i < lanes<Real>; ++i) sum += lane[i];
    return sum;
  }

  // z [16] = w x + bias for a few outputs O, w [outputs][In] and x padded to a multiple of 16; the rest of z
  // is 0.
  template <typename Real, int In, int... O>
  inline void dense_narrow(const Real* w, const Real* bias, const Real* x, Real* z,
                           std::integer_sequence<int, O...>) noexcept {
    PackOf<Real> sum[sizeof...(O)];
    ((sum[O] = PackOf<Real>{}), ...);
    for (int k = 0; k < In; k += lanes<Real>) {
      PackOf<Real> input, weight;
      load<Real>(x + k, input);
      ((load<Real>(w + O * In + k, weight), sum[O] += weight * input), ...);
    }
    for (int i = 0; i < 16; ++i) z[i] = Real(0);
    ((z[O] = bias[O] + sum_of<Real>(sum[O])), ...);
  }

  template <typename Real>
  struct Constants;
  template <>
  struct Constants<float> {
    static constexpr float magic = 12582912.0F;  // 1.5 * 2^23: adding it rounds to an integer
    static constexpr std::uint32_t one = 0x3f800000U;
    static constexpr int mantissa = 23, terms = 7;
    static constexpr float ln2_high = 0.693359375F, ln2_low = -2.12194440e-4F;
    static constexpr float exp_floor = -87.0F, tanh_ceiling = 10.0F;
  };
  template <>
  struct Constants<double> {
    static constexpr double magic = 6755399441055744.0;  // 1.5 * 2^52
    static constexpr std::uint64_t one = 0x3ff0000000000000U;
    static constexpr int mantissa = 52, terms = 13;
    static constexpr double ln2_high = 6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10;
    static constexpr double exp_floor = -708.0, tanh_ceiling = 22.0;
  };

  template <typename Real>
  constexpr Real reciprocal_factorial(int k) noexcept {
    double factorial = 1.0;
    for (int i = 2; i <= k; ++i) factorial *= i;
    return static_cast<Real>(1.0 / factorial);
  }

  // (exp(r) - 1) / r by its Taylor series, for |r| <= ln(2) / 2.
  template <typename Real, int Term = 1>
  inline void expm1_series(const PackOf<Real>& r, PackOf<Real>& sum) noexcept {
    if constexpr (Term == Constants<Real>::terms) {
      sum = PackOf<Real>{} + reciprocal_factorial<Real>(Term);
    } else {
      expm1_series<Real, Term + 1>(r, sum);
      sum = sum * r + reciprocal_factorial<Real>(Term);
    }
  }

  // exp(x) and exp(x) - 1 for x <= 0, by x = n ln 2 + r. NaN stays NaN.
  template <typename Real>
  inline void exp_of_negative(PackOf<Real> x, PackOf<Real>& exp, PackOf<Real>& expm1) noexcept {
    using C = Constants<Real>;
    x = x < C::exp_floor ? PackOf<Real>{} + C::exp_floor : x;
    const PackOf<Real> shifted = x * Real(1.4426950408889634) + C::magic;
    const PackOf<Real> n = shifted - C::magic;
    const PackOf<Real> r = (x - n * C::ln2_high) - n * C::ln2_low;
    typename Simd<Real>::Bits bits;
    std::memcpy(&bits, &shifted, sizeof bits);
    bits = (bits << C::mantissa) + C::one;  // the low bits of `shifted` are n: this is 2^n
    PackOf<Real> power, series;
    std::memcpy(&power, &bits, sizeof power);
    expm1_series<Real>(r, series);
    const PackOf<Real> small = series * r;
    expm1 = power * small + (power - Real(1));
    exp = power * small + power;
  }

  // The activations z -> sigma(z), in place.
  struct Identity {
    template <typename Real>
    static void of(PackOf<Real>&) noexcept {}
  };
  // x (1 + p1 x^2 + ... + p4 x^8) / (1 + q1 x^2 + ... + q4 x^8), fitted to tanh on [-9, 9] in the largest
  // absolute error: 2.1e-8, and 3.6e-7 with the roundings of float. Beyond, tanh is 1 to within 3.1e-8.
  inline void rational_tanh(PackOf<float>& z) noexcept {
    constexpr float end = 9.0F;
    z = z > end ? PackOf<float>{} + end : z;  // NaN stays NaN
    z = z < -end ? PackOf<float>{} - end : z;
    const PackOf<float> t = z * z;
    const PackOf<float> p =
        (((1.333800359e-8F * t + 2.059605140e-5F) * t + 3.494756762e-3F) * t + 1.338031590e-1F) * t + 1.0F;
    const PackOf<float> q =
        (((7.769438071e-7F * t + 3.284301492e-4F) * t + 2.587378584e-2F) * t + 4.671363235e-1F) * t + 1.0F;
    z = z * p / q;
  }
  struct Tanh {
    template <typename Real>
    static void of(PackOf<Real>& z) noexcept {
      if constexpr (sizeof(Real) == sizeof(float)) {
        rational_tanh(z);
      } else {
        constexpr Real ceiling = Constants<Real>::tanh_ceiling;
        PackOf<Real> x = z < Real(0) ? -z : z, exp, e;
        x = x > ceiling ? PackOf<Real>{} + ceiling : x;
        exp_of_negative<Real>(x * Real(-2), exp, e);
        const PackOf<Real> value = -e / (e + Real(2));
        z = z < Real(0) ? -value : value;
      }
    }
  };
  struct Elu {
    template <typename Real>
    static void of(PackOf<Real>& z) noexcept {
      PackOf<Real> exp, e;
      exp_of_negative<Real>(z > Real(0) ? PackOf<Real>{} : z, exp, e);
      z = z > Real(0) ? z : e;
    }
  };
  struct Silu {
    template <typename Real>
    static void of(PackOf<Real>& z) noexcept {
      PackOf<Real> exp, e;
      exp_of_negative<Real>(z > Real(0) ? -z : z, exp, e);
      const PackOf<Real> below = exp / (exp + Real(1)), above = PackOf<Real>{} + Real(1);
      z *= z > Real(0) ? above / (exp + Real(1)) : below;
    }
  };
  // The two below go number by number through the standard library.
  template <typename Real, typename Function>
  inline void each(PackOf<Real>& z, Function function) noexcept {
    Real lane[static_cast<unsigned>(lanes<Real>)];
    store<Real>(z, lane);
    for (Real& value : lane) value = function(value);
    load<Real>(lane, z);
  }
  struct Softplus {
    template <typename Real>
    static void of(PackOf<Real>& z) noexcept {
      each<Real>(z,
                 [](Real v) { return v > Real(0) ? v + std::log1p(std::exp(-v)) : std::log1p(std::exp(v)); });
    }
  };
  struct Sine {
    template <typename Real>
    static void of(PackOf<Real>& z) noexcept {
      each<Real>(z, [](Real v) { return std::sin(v); });
    }
  };

  template <typename Activation, int Count, typename Real>
  inline void activate(Real* z) noexcept {
    for (int i = 0; i < Count; i += lanes<Real>) {
      PackOf<Real> pack;
      load<Real>(z + i, pack);
      Activation::template of<Real>(pack);
      store<Real>(pack, z + i);
    }
  }
)cpp";

}  // namespace s2nnds
