// SPDX-License-Identifier: BSD-3-Clause
// The part of an exported C++ header that is the same for every policy: dense layers and activations, inside
// the policy's namespace `detail` and behind networks/simd_exponential.inl. It needs <cmath> and <utility>.
// Against exact arithmetic its activations are wrong by at most 3 units in the last place (of 1, where they
// are bounded), which float32_error() (verification/rounding_error.h) covers with its 8.

// Some columns of z = w x + bias, w [In][Out], kept in registers over all of x. With few columns, even and
// odd inputs are summed apart: one chain of additions would wait for itself.
template <typename Real, int In, int Out, int First, int... J>
inline void dense_block(const Real* w, const Real* bias, const Real* x, Real* z,
                        std::integer_sequence<int, J...>) noexcept {
  constexpr int count = static_cast<int>(sizeof...(J)), width = lanes<Real>;
  constexpr bool apart = count <= 4 && In > 1;
  PackOf<Real> even[count], odd[count];
  ((even[J] = load(bias + First + J * width)), ...);
  ((odd[J] = PackOf<Real>{}), ...);
  int k = 0;
  for (; k + 1 < In; k += 2) {
    const Real* row = w + k * Out + First;
    ((even[J] += load(row + J * width) * x[k]), ...);
    (((apart ? odd[J] : even[J]) += load(row + Out + J * width) * x[k + 1]), ...);
  }
  if (In % 2 == 1) ((even[J] += load(w + k * Out + First + J * width) * x[k]), ...);
  if (apart) ((even[J] += odd[J]), ...);
  (store(z + First + J * width, even[J]), ...);
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
  store(lane, pack);
  Real sum = lane[0];
  for (int i = 1; i < lanes<Real>; ++i) sum += lane[i];
  return sum;
}

// z [16] = w x + bias for a few outputs O, w [outputs][In] and x padded to a multiple of 16; the rest of z is
// 0.
template <typename Real, int In, int... O>
inline void dense_narrow(const Real* w, const Real* bias, const Real* x, Real* z,
                         std::integer_sequence<int, O...>) noexcept {
  PackOf<Real> sum[sizeof...(O)];
  ((sum[O] = PackOf<Real>{}), ...);
  for (int k = 0; k < In; k += lanes<Real>) {
    const PackOf<Real> input = load(x + k);
    ((sum[O] += load(w + O * In + k) * input), ...);
  }
  for (int i = 0; i < 16; ++i) z[i] = Real(0);
  ((z[O] = bias[O] + sum_of<Real>(sum[O])), ...);
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
      constexpr Real ceiling = Simd<Real>::tanh_ceiling;
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
  store(lane, z);
  for (Real& value : lane) value = function(value);
  z = load<Real>(lane);
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
    PackOf<Real> pack = load(z + i);
    Activation::template of<Real>(pack);
    store(z + i, pack);
  }
}

// d sigma / dz of the activations, from z and sigma(z).
inline double slope(Identity, double, double) noexcept { return 1.0; }
inline double slope(Tanh, double, double a) noexcept { return 1.0 - a * a; }
inline double slope(Elu, double z, double a) noexcept { return z > 0.0 ? 1.0 : a + 1.0; }
inline double slope(Softplus, double, double a) noexcept { return -std::expm1(-a); }
inline double slope(Silu, double z, double a) noexcept {
  const double s = 1.0 / (1.0 + std::exp(-z));
  return s + a * (1.0 - s);
}
inline double slope(Sine, double z, double) noexcept { return std::cos(z); }

// a = sigma(z) and slopes = d sigma / dz, each [Count].
template <typename Activation, int Count>
inline void activate_with_slopes(const double* z, double* a, double* slopes) noexcept {
  std::memcpy(a, z, Count * sizeof(double));
  activate<Activation, Count>(a);
  for (int i = 0; i < Count; ++i) slopes[i] = slope(Activation{}, z[i], a[i]);
}

// a [In] = w' z for w as dense() takes it.
template <int In, int Out>
inline void pull_back(const double* w, const double* z, double* a) noexcept {
  for (int k = 0; k < In; ++k) {
    PackOf<double> sum{};
    for (int i = 0; i < Out; i += lanes<double>) sum += load(w + k * Out + i) * load(z + i);
    a[k] = sum_of<double>(sum);
  }
}
// The same for w as dense_narrow() takes it.
template <int In, int Outputs>
inline void pull_back_narrow(const double* w, const double* z, double* a) noexcept {
  for (int k = 0; k < In; ++k) {
    a[k] = 0.0;
    for (int i = 0; i < Outputs; ++i) a[k] += w[i * In + k] * z[i];
  }
}
