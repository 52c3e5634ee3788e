// SPDX-License-Identifier: BSD-3-Clause
// The source of the Taylor kernels, included once per instruction set with S2NNDS_KERNEL_SPACE, the
// namespace, and SIMD_REGISTER_BYTES, the register width. Only GCC's vector extensions and the C library's
// functions are used, so that no inline function compiled for a newer processor can reach the rest of the
// program. Never compiled with -ffast-math; contraction to fused operations only removes roundings that the
// bounds already cover.

#include <math.h>

#include <cstdint>
#include <cstring>

#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/taylor_kernels.h"

namespace s2nnds::S2NNDS_KERNEL_SPACE {
namespace {

#include "s2nnds/networks/simd_exponential.inl"

using Lanes = PackOf<double>;
typedef std::int64_t Words
    __attribute__((vector_size(SIMD_REGISTER_BYTES)));  // what comparisons of Lanes give

inline Lanes all(double x) { return Lanes{} + x; }
// NaN in either argument of smaller and larger may get lost: their callers carry it along by other paths.
inline Lanes smaller(Lanes x, Lanes y) { return x < y ? x : y; }
inline Lanes larger(Lanes x, Lanes y) { return x > y ? x : y; }
inline Lanes magnitude(Lanes x) {  // without the sign's bit
  return Lanes(Words(x) & INT64_MAX);
}

// The coefficients' own errors: every value, first, second, third below is within this of the exact one, and every fourth
// within four times this, times max(1, |z0|) where z0 enters as a factor.
constexpr double coefficient_error = 0x1p-43;

// e^x for x <= 0, relative error below 2^-49 for x >= -708; below that e^-708, which is wrong by less than
// 1e-307. x = k ln 2 + r, |r| <= 0.3467 (k ln2_high is exact, so r is wrong by less than 2^-53), Taylor sum
// to degree 13 (truncation below 5e-18), Horner's roundings below 2 units, one for the last product.
inline Lanes exp_of_negative(Lanes x) {
  Lanes power, series, r;
  split_exponential<double>(x, power, series, r);
  return (series * r + 1.0) * power;
}

struct Expansion {
  Lanes value, first, second, third, fourth, value_error, linear_error, first_error, value_rest, first_rest;

  // Without terms beyond second order: the rests are the errors.
  void leave(Words where) {
    third = where ? all(0.0) : third;
    fourth = where ? all(0.0) : fourth;
    value_rest = where ? value_error : value_rest;
    first_rest = where ? first_error : first_rest;
  }
};

// Errors from bounds on |sigma''|, ..., |sigma'''''| over the range (Taylor's theorem with Lagrange's remainder) and,
// anywhere, on |sigma' - first|, |sigma'' - second|, |sigma''' - third|.
inline void remainders(Lanes radius, Lanes scale, Lanes second_bound, Lanes third_bound, Lanes fourth_bound,
                       Lanes fifth_bound, double first_spread, double second_spread, double third_spread,
                       Expansion& e) {
  const Lanes square = radius * radius, cube = square * radius;
  const Lanes rounding = coefficient_error * scale * (1.0 + radius + square);
  e.value_error =
      smaller(third_bound * radius * (1.0 / 6.0), all(0.5 * second_spread)) * square * slack + rounding;
  e.linear_error =
      smaller(0.5 * second_bound * square, 0.5 * magnitude(e.second) * square + e.value_error) * slack +
      rounding;
  e.first_error =
      smaller(fourth_bound * radius * (1.0 / 6.0), all(0.5 * third_spread)) * square * slack + rounding;
  const Lanes rest_rounding = rounding + coefficient_error * scale * cube;
  e.value_rest =
      smaller(fourth_bound * radius * (1.0 / 24.0), all(third_spread / 6.0)) * cube * slack + rest_rounding;
  const Lanes first_rest = fifth_bound * square * square * (slack / 24.0) + rest_rounding;
  const Words fine = first_rest < e.first_error;
  e.fourth = fine ? e.fourth : all(0.0);
  e.first_rest = fine ? first_rest : e.first_error;
  // On wide ranges a plain line, and a plain number for sigma', are better.
  const Lanes line_rounding = coefficient_error * scale * (1.0 + radius);
  const Words wide = (radius > 0.5) & (first_spread * radius < e.linear_error);
  e.second = wide ? all(0.0) : e.second;
  e.linear_error = wide ? first_spread * radius * slack + line_rounding : e.linear_error;
  e.value_error = wide ? e.linear_error : e.value_error;
  e.first_error = wide ? first_spread + line_rounding : e.first_error;
  e.leave(wide);
}

inline bool any_above(Lanes x, double limit) {
  Words above = x > limit;
  for (int step = lanes<double> / 2; step > 0; step /= 2) {
    Words partner = above;
    for (int i = 0; i < lanes<double>; ++i) partner[i] = i ^ step;
    above |= __builtin_shuffle(above, partner);
  }
  return above[0] != 0;
}

// The range of |tanh| over |z - z0| <= radius, from t0 = tanh(z0) within 2^-45: by the addition theorem
// tanh(z0 +- d) lies within (t0 +- d) / (1 +- t0 d) for tanh(d) <= d, brought to the denominator 1 - (t0 d)^2 > 0.19.
inline void tanh_range(Lanes t0, Lanes radius, Lanes& low, Lanes& high) {
  const Lanes t = magnitude(t0), d = smaller(radius, all(0.9)), product = t * d;
  const Lanes inverse = 1.0 / (1.0 - product * product);
  const Words narrow = radius <= 0.9;
  high = narrow ? smaller((t + d) * (1.0 - product) * inverse + 0x1p-40, all(1.0)) : all(1.0);
  // (t - d) / (1 - t d) falls with d, and magnifies the error of t0 by at most (1 + d) / (1 - d).
  low = narrow ? larger((t - d) * (1.0 + product) * inverse - 0x1p-40, all(0.0)) : all(0.0);
}

// max of 2 t (1 - t^2) = |tanh''| over t in [low, high] within [0, 1]; its peak is at 1/sqrt(3).
inline Lanes tanh_second_bound(Lanes low, Lanes high) {
  const Lanes at_low = 2.0 * low * (1.0 - low * low), at_high = 2.0 * high * (1.0 - high * high);
  const Lanes peak =
      (low <= 0.57735026918962577) & (high >= 0.57735026918962573) ? all(0.76980035891950105) : all(0.0);
  return larger(larger(at_low, at_high), peak) + 0x1p-48;
}

// max of |(1 - t^2) (6 t^2 - 2)| = |tanh'''|; local peaks 2 at 0 and 2/3 at t^2 = 2/3.
inline Lanes tanh_third_bound(Lanes low, Lanes high) {
  const Lanes u = low * low, w = high * high;
  const Lanes at_low = magnitude((1.0 - u) * (6.0 * u - 2.0)),
              at_high = magnitude((1.0 - w) * (6.0 * w - 2.0));
  const Lanes peak =
      (u <= 0.6666666666666668) & (w >= 0.6666666666666665) ? all(0.66666666666666674) : all(0.0);
  return larger(larger(at_low, at_high), peak) + 0x1p-48;
}

// max of |t (1 - t^2) (16 - 24 t^2)| = |tanh''''|; local peaks 4.08588... at t^2 = (15 - sqrt(105)) / 30 and
// 0.61009... at t^2 = (15 + sqrt(105)) / 30.
inline Lanes tanh_fourth_bound(Lanes low, Lanes high) {
  const Lanes u = low * low, w = high * high;
  const Lanes at_low = magnitude(low * (1.0 - u) * (16.0 - 24.0 * u));
  const Lanes at_high = magnitude(high * (1.0 - w) * (16.0 - 24.0 * w));
  const Lanes first_peak = (u <= 0.158435) & (w >= 0.158434) ? all(4.0859) : all(0.0);
  const Lanes second_peak = (u <= 0.841566) & (w >= 0.841565) ? all(0.6102) : all(0.0);
  return larger(larger(at_low, at_high), larger(first_peak, second_peak)) + 0x1p-46;
}

// Above |(1 - t^2) (16 - 120 t^2 (1 - t^2))| = |tanh'''''|, of which the second factor lies in [-14, 16].
inline Lanes tanh_fifth_bound(Lanes low) { return 16.0 * (1.0 - low * low) + 0x1p-40; }

// tanh(z) with an absolute error below 2^-46, and e = exp(-2 |z|).
inline Lanes tanh_of(Lanes z) {
  const Lanes e = exp_of_negative(-2.0 * magnitude(z));
  const Lanes t = (1.0 - e) / (1.0 + e);
  return z < 0.0 ? -t : t;
}

// On ranges so wide that tanh is better described by a number than by its tangent.
inline void flatten_tanh(Lanes z0, Lanes radius, Expansion& e) {
  const Lanes low = tanh_of(z0 - radius), high = tanh_of(z0 + radius);
  const Lanes reach =
      0.5 * (high - low) + 0x1p-40;  // with the roundings of z0 -+ radius, as |tanh'| z is bounded
  const Words flat = reach < e.linear_error;
  const Lanes steepest = 1.0 - smaller(low * low, high * high) + 0x1p-40;
  e.value = flat ? 0.5 * (low + high) : e.value;
  e.first = flat ? all(0.0) : e.first;
  e.second = flat ? all(0.0) : e.second;
  e.linear_error = flat ? reach : e.linear_error;
  e.value_error = flat ? reach : e.value_error;
  e.first_error = flat ? ((low < 0.0) & (high > 0.0) ? all(1.0) : steepest) : e.first_error;
  e.leave(flat);
}

// Where e.value is tanh(z0).
inline void expand_tanh(Lanes radius, Expansion& e) {
  const Lanes t = e.value, w = t * t;
  e.first = 1.0 - w;
  e.second = -2.0 * t * e.first;
  e.third = e.first * (6.0 * w - 2.0);
  e.fourth = t * e.first * (16.0 - 24.0 * w);
  Lanes low, high;
  tanh_range(t, radius, low, high);
  remainders(radius, all(1.0), tanh_second_bound(low, high), tanh_third_bound(low, high),
             tanh_fourth_bound(low, high), tanh_fifth_bound(low), 1.0, 1.5397, 2.6667, e);
}

// In short loops, of which the processor works on several turns at once: one turn of all this is a long chain.
inline void expand_tanh(ptrdiff_t count, const Lanes* z0, const Lanes* radius, Expansion* e) {
  Lanes widest = all(0.0);
  for (ptrdiff_t k = 0; k < count; ++k) e[k].value = tanh_of(z0[k]);
  for (ptrdiff_t k = 0; k < count; ++k) {
    expand_tanh(radius[k], e[k]);
    widest = larger(widest, radius[k]);
  }
  if (!any_above(widest, 0.75)) return;
  for (ptrdiff_t k = 0; k < count; ++k) {
    if (any_above(radius[k], 0.75)) flatten_tanh(z0[k], radius[k], e[k]);
  }
}

// s = 1 / (1 + exp(-z)) = (1 + tanh(z / 2)) / 2, so that s'' and its derivatives are tanh's, scaled.
struct Logistic {
  Lanes s, first, second, third, fourth;                       // s, s', ... at z0
  Lanes first_bound, second_bound, third_bound, fourth_bound;  // of |s'|, |s''|, ... over the range
};
inline Logistic logistic(Lanes z0, Lanes radius) {
  Logistic l;
  const Lanes t = tanh_of(0.5 * z0), w = t * t;
  Lanes low, high;
  tanh_range(t, 0.5 * radius, low, high);
  l.s = 0.5 + 0.5 * t;
  l.first = 0.25 * (1.0 - w);
  l.second = -t * l.first;
  l.third = 0.25 * l.first * (6.0 * w - 2.0);
  l.fourth = t * l.first * (2.0 - 3.0 * w);
  l.first_bound = 0.25 * (1.0 - low * low) + 0x1p-40;
  l.second_bound = 0.125 * tanh_second_bound(low, high);
  l.third_bound = 0.0625 * tanh_third_bound(low, high);
  l.fourth_bound = 0.03125 * tanh_fourth_bound(low, high);
  return l;
}

// log(1 + e^z) = max(z, 0) + log1p(exp(-|z|)), the C library's log1p being wrong by at most 4 units in the
// last place.
inline Lanes softplus_of(Lanes z) {
  Lanes e = exp_of_negative(-magnitude(z));
  for (int i = 0; i < lanes<double>; ++i) e[i] = log1p(e[i]);
  return (z < 0.0 ? all(0.0) : z) + e;
}

inline void expand_softplus(Lanes z0, Lanes radius, Expansion& e) {
  const Logistic l = logistic(z0, radius);
  e.value = softplus_of(z0);
  e.first = l.s;
  e.second = l.first;
  e.third = l.second;
  e.fourth = l.third;
  remainders(radius, 1.0 + magnitude(z0), l.first_bound, l.second_bound, l.third_bound, l.fourth_bound, 1.0,
             0.2501, 0.1926, e);
}

// z s(z); its k-th derivative is k s^(k-1) + z s^(k). Over the range: the value at z0 plus radius times a
// bound of the next derivative, or the triangle inequality, or the bound on the whole line: 0.5, 0.30819, 0.5
// and 0.65803 for the second to the fifth derivative.
inline void expand_silu(Lanes z0, Lanes radius, Expansion& e) {
  const Logistic l = logistic(z0, radius);
  const Lanes farthest = magnitude(z0) + radius, scale = 4.0 * (1.0 + magnitude(z0));
  e.value = z0 * l.s;
  e.first = l.s + z0 * l.first;
  e.second = 2.0 * l.first + z0 * l.second;
  e.third = 3.0 * l.second + z0 * l.third;
  e.fourth = 4.0 * l.third + z0 * l.fourth;
  const Lanes rounding = 0x1p-40 * scale;
  const Lanes second_bound = smaller(2.0 * l.first_bound + farthest * l.second_bound, all(0.5001));
  const Lanes fourth_bound = smaller(magnitude(e.fourth) + 0.6581 * radius + rounding, all(0.5001));
  const Lanes third_bound = smaller(smaller(3.0 * l.second_bound + farthest * l.third_bound,
                                            magnitude(e.third) + radius * fourth_bound + rounding),
                                    all(0.3082));
  remainders(radius, scale, second_bound, third_bound, fourth_bound, all(0.6581), 1.2, 0.5371, 0.6164, e);
}

// exp(z) - 1 below 0, z above: sigma'' jumps from 1 to 0 at 0. On a range around 0, sigma'' lies in [0, 1]
// almost everywhere, so both Taylor polynomials take 1/2 for it and leave a remainder of lower order.
inline void expand_elu(Lanes z0, Lanes radius, Expansion& e) {
  const Words wide = radius > 2.0, above = z0 - radius > 0.0, below = z0 + radius<0.0, positive = z0> 0.0;
  const Lanes power = exp_of_negative(positive ? all(0.0) : z0);
  const Lanes bound =
      smaller(power / (1.0 - smaller(radius, all(0.99))), all(1.0)) + 0x1p-48;  // e^r <= 1 / (1 - r)
  const Lanes square = radius * radius;
  const Lanes rounding = coefficient_error * (1.0 + radius + square);
  e.value = positive ? z0 : power - 1.0;
  e.first = positive ? all(1.0) : power;
  e.second = above ? all(0.0) : (below ? power : all(0.5));
  e.third = e.fourth = below ? power : all(0.0);
  const Lanes cubic = smaller(bound * radius * (1.0 / 6.0), all(0.5)) * square;
  e.value_error = (above ? all(0.0) : (below ? cubic : 0.25 * square)) * slack + rounding;
  e.linear_error = (above ? all(0.0) : (below ? 0.5 * bound * square : 0.5 * square)) * slack + rounding;
  e.first_error = (above ? all(0.0) : (below ? cubic : 0.5 * radius)) * slack + rounding;
  // Beyond the third order below 0; there all derivatives are e^z.
  const Lanes quartic =
      bound * square * square * (slack / 24.0) + rounding + coefficient_error * radius * square;
  const Words fine = below & (quartic < e.first_error);
  e.first_rest = fine ? quartic : e.first_error;
  e.value_rest =
      below ? smaller(quartic, e.value_error + power * radius * square * (slack / 6.0)) : e.value_error;
  e.fourth = fine ? e.fourth : all(0.0);
  const Words line = wide & ~above;  // 0 <= sigma' <= 1
  e.second = line ? all(0.0) : e.second;
  e.linear_error = line ? radius * slack + rounding : e.linear_error;
  e.value_error = line ? e.linear_error : e.value_error;
  e.first_error = line ? 1.0 + rounding : e.first_error;
  e.leave(line);
}

// The C library's sin and cos, wrong by at most 4 units in the last place.
// |sin(z0 + d)| <= |sin z0| + |cos z0| |d|, and so for cos.
inline void expand_sine(Lanes z0, Lanes radius, Expansion& e) {
  Lanes sine = z0, cosine = z0;
  for (int i = 0; i < lanes<double>; ++i) {
    sine[i] = sin(z0[i]);
    cosine[i] = cos(z0[i]);
  }
  e.value = sine;
  e.first = cosine;
  e.second = -sine;
  e.third = -cosine;
  e.fourth = sine;
  const Lanes sine_bound = smaller(magnitude(sine) + magnitude(cosine) * radius + 0x1p-48, all(1.0));
  const Lanes cosine_bound = smaller(magnitude(cosine) + magnitude(sine) * radius + 0x1p-48, all(1.0));
  remainders(radius, all(1.0), sine_bound, cosine_bound, sine_bound, cosine_bound, 2.0, 2.0001, 2.0001, e);
  const Words flat = e.linear_error > 1.0;
  e.value = flat ? all(0.0) : e.value;
  e.first = flat ? all(0.0) : e.first;
  e.second = flat ? all(0.0) : e.second;
  e.linear_error = flat ? all(1.0) : e.linear_error;
  e.value_error = flat ? all(1.0) : e.value_error;
  e.first_error = flat ? all(1.0) : e.first_error;
  e.leave(flat);
}

inline void expand_identity(Lanes z0, Lanes radius, Expansion& e) {
  e.value = z0;
  e.first = all(1.0);
  e.second = e.third = e.fourth = e.value_error = e.linear_error = e.first_error = e.value_rest =
      e.first_rest = 0.0 * radius;
}

inline void expand_other(Activation activation, Lanes z0, Lanes radius, Expansion& e) {
  switch (activation) {
    case Activation::identity:
      return expand_identity(z0, radius, e);
    case Activation::elu:
      return expand_elu(z0, radius, e);
    case Activation::softplus:
      return expand_softplus(z0, radius, e);
    case Activation::silu:
      return expand_silu(z0, radius, e);
    case Activation::sine:
      return expand_sine(z0, radius, e);
    case Activation::tanh:
      break;
  }
  e.value = e.first = e.second = e.third = e.fourth = e.value_error = e.linear_error = e.first_error =
      e.value_rest = e.first_rest = all(__builtin_nan(""));
}

// `count` neurons: z0, radius and e [count].
void expand_lanes(Activation activation, ptrdiff_t count, const Lanes* z0, const Lanes* radius, Expansion* e) {
  if (activation == Activation::tanh) return expand_tanh(count, z0, radius, e);
  for (ptrdiff_t k = 0; k < count; ++k) expand_other(activation, z0[k], radius[k], e[k]);
}

void expand(Activation activation, const double* z0, const double* radius, ActivationExpansion& result) {
  for (ptrdiff_t t = 0; t < tile_boxes; t += lanes<double>) {
    Expansion e;
    const Lanes center = load(z0 + t), reach = load(radius + t);
    expand_lanes(activation, 1, &center, &reach, &e);
    store(result.value + t, e.value);
    store(result.first + t, e.first);
    store(result.second + t, e.second);
    store(result.third + t, e.third);
    store(result.fourth + t, e.fourth);
    store(result.value_error + t, e.value_error);
    store(result.linear_error + t, e.linear_error);
    store(result.first_error + t, e.first_error);
    store(result.value_rest + t, e.value_rest);
    store(result.first_rest + t, e.first_rest);
  }
}

// sum_d |slope_d| half_d, rounded up.
inline Lanes spread(const double* slopes, const double* half, ptrdiff_t n) {
  Lanes sum = all(0.0);
  for (ptrdiff_t d = 0; d < n; ++d)
    sum += magnitude(load(slopes + d * tile_boxes)) * load(half + d * tile_boxes);
  return sum * slack;
}

// Above |dx' H dx / 2|, from the rows of H's upper triangle.
inline Lanes quadratic_size(const double* hessian, const double* half, ptrdiff_t n) {
  Lanes sum = all(0.0);
  for (ptrdiff_t d = 0; d < n; ++d) {
    Lanes row = 0.5 * magnitude(load(hessian)) * load(half + d * tile_boxes);
    hessian += tile_boxes;
    for (ptrdiff_t e = d + 1; e < n; ++e, hessian += tile_boxes)
      row += magnitude(load(hessian)) * load(half + e * tile_boxes);
    sum += row * load(half + d * tile_boxes);
  }
  return sum * slack;
}

// Completes the remainder of neuron i's stream with the roundings of the affine map.
inline Lanes complete_remainder(const LayerTile& layer, ptrdiff_t i, ptrdiff_t stream, ptrdiff_t t) {
  const double* r = layer.z_remainder + (i * layer.streams + stream) * tile_boxes + t;
  const Lanes rounding = layer.row_error[i] * load(layer.magnitude_in + stream * tile_boxes + t) +
                         (stream == 0 ? layer.bias_error[i] : 0.0);
  return (load(r) * layer.remainder_growth + rounding) * slack;
}

constexpr double twice = 4.0 * unit_roundoff;  // relative error of two or three operations, with room

// hessian += weight (p q' + q p') / 2 over the upper triangle.
inline void add_product(double* hessian, Lanes weight, const double* p, const double* q, ptrdiff_t n) {
  for (ptrdiff_t d = 0; d < n; ++d) {
    const Lanes pd = weight * load(p + d * tile_boxes), qd = weight * load(q + d * tile_boxes);
    for (ptrdiff_t e = d; e < n; ++e, hessian += tile_boxes) {
      store(hessian, load(hessian) + 0.5 * (pd * load(q + e * tile_boxes) + qd * load(p + e * tile_boxes)));
    }
  }
}
inline void add_square(double* hessian, Lanes weight, const double* p, ptrdiff_t n) {
  for (ptrdiff_t d = 0; d < n; ++d) {
    const Lanes pd = weight * load(p + d * tile_boxes);
    for (ptrdiff_t e = d; e < n; ++e, hessian += tile_boxes) {
      store(hessian, load(hessian) + pd * load(p + e * tile_boxes));
    }
  }
}

// What comes into a neuron: z - z0 = line + deviation = line + quadratic + r, as sizes; and its derivative.
struct Reach {
  Reach(const double* model, Lanes remainder, const double* half, ptrdiff_t n)
      : line(spread(model + tile_boxes, half, n)),
        deviation((quadratic_size(model + (1 + n) * tile_boxes, half, n) + remainder) * slack),
        radius((line + deviation) * slack) {}
  Lanes line, deviation, radius;
};

// Neurons that are taken through an activation together.
constexpr ptrdiff_t together = 8;

void activate(const LayerTile& layer) {
  const ptrdiff_t n = layer.dimension, columns = 1 + n + n * (n + 1) / 2;
  const ptrdiff_t block = columns * tile_boxes, row = layer.streams * block, hessian = (1 + n) * tile_boxes;
  Lanes z0[together], radii[together];
  Expansion expansions[together];
  for (ptrdiff_t t = 0; t < tile_boxes; t += lanes<double>) {
    const double* half = layer.half + t;
    Lanes largest = all(0.0);
    for (ptrdiff_t s = 1; s < layer.streams; ++s) store(layer.magnitude_out + s * tile_boxes + t, all(0.0));
    for (ptrdiff_t i = 0; i < layer.width; ++i) {
      const ptrdiff_t k = i % together;
      if (k == 0) {
        const ptrdiff_t count = i + together < layer.width ? together : layer.width - i;
        for (ptrdiff_t j = 0; j < count; ++j) {
          const double* z = layer.z + (i + j) * row + t;
          const Lanes r = complete_remainder(layer, i + j, 0, t);
          store(layer.z_remainder + (i + j) * layer.streams * tile_boxes + t, r);
          z0[j] = load(z);
          radii[j] = Reach(z, r, half, n).radius;
        }
        expand_lanes(layer.activation, count, z0, radii, expansions);
      }
      const double* z = layer.z + i * row + t;
      double* a = layer.a + i * row + t;
      double* kept = layer.expansion + i * kept_rows * tile_boxes + t;
      double* z_remainder = layer.z_remainder + i * layer.streams * tile_boxes + t;
      double* out_remainder = layer.a_remainder + i * layer.streams * tile_boxes + t;
      // z - z0 = linear + quadratic + r = linear + deviation, as sizes.
      const Lanes r = load(z_remainder), radius = radii[k];
      const Lanes linear = spread(z + tile_boxes, half, n), quadratic = quadratic_size(z + hessian, half, n);
      const Lanes deviation = (quadratic + r) * slack;
      const Lanes square_error = deviation * (linear + radius);  // of (z - z0)^2 against linear^2
      const Expansion& e = expansions[k];
      store(kept, e.first);
      store(kept + tile_boxes, e.second);
      store(kept + 2 * tile_boxes, e.third);
      store(kept + 3 * tile_boxes, e.fourth);
      store(kept + 4 * tile_boxes, e.value_rest);
      store(kept + 5 * tile_boxes, e.first_rest);
      const Lanes first = magnitude(e.first), second = magnitude(e.second);
      store(a, e.value);
      for (ptrdiff_t d = 1; d < columns; ++d) store(a + d * tile_boxes, e.first * load(z + d * tile_boxes));
      add_square(a + hessian, e.second, z + tile_boxes, n);
      const Lanes bent = first * quadratic + 0.5 * second * linear * linear;
      store(out_remainder, (first * r + 0.5 * second * square_error + e.value_error +
                            twice * (first * linear + 2.0 * bent)) *
                               slack);
      largest = larger(largest, magnitude(e.value) + first * linear + bent);
      // p = sigma'(z) zdot about (z0, zdot0), for each derivative.
      for (ptrdiff_t s = 1; s < layer.streams; ++s) {
        const double* rate = z + s * block;
        const Lanes rate_r = complete_remainder(layer, i, s, t);
        const Lanes rate_linear = spread(rate + tile_boxes, half, n);
        const Lanes rate_quadratic = quadratic_size(rate + hessian, half, n);
        const Lanes rate_deviation = (rate_quadratic + rate_r) * slack;
        const Lanes rate_radius = (rate_linear + rate_deviation) * slack;
        store(z_remainder + s * tile_boxes, rate_r);
        const Lanes rate0 = load(rate), cross = e.second * rate0, bend = e.third * rate0;
        const Lanes cross_size = magnitude(cross), bend_size = magnitude(bend);
        store(a + s * block, e.first * rate0);
        for (ptrdiff_t d = 1; d < columns; ++d) {
          store(a + s * block + d * tile_boxes,
                e.first * load(rate + d * tile_boxes) + cross * load(z + d * tile_boxes));
        }
        add_square(a + s * block + hessian, bend, z + tile_boxes, n);
        add_product(a + s * block + hessian, 2.0 * e.second, z + tile_boxes, rate + tile_boxes, n);
        const Lanes rate_size = magnitude(rate0) + rate_radius;
        const Lanes rate_line = first * rate_linear + cross_size * linear;
        const Lanes rate_bent = first * rate_quadratic + cross_size * quadratic +
                                0.5 * bend_size * linear * linear + second * linear * rate_linear;
        const Lanes rounding = twice * (first * magnitude(rate0) + rate_line + 3.0 * rate_bent);
        const Lanes cubic =
            second * (deviation * rate_radius + linear * rate_deviation) + 0.5 * bend_size * square_error +
            0.5 * magnitude(e.third) * radius * radius * rate_radius + e.first_error * rate_size;
        store(out_remainder + s * tile_boxes, (first * rate_r + cross_size * r + cubic + rounding) * slack);
        double* size = layer.magnitude_out + s * tile_boxes + t;
        store(size, larger(load(size), first * magnitude(rate0) + rate_line + rate_bent));
      }
    }
    store(layer.magnitude_out + t, largest * slack);
    for (ptrdiff_t s = 1; s < layer.streams; ++s) {
      double* size = layer.magnitude_out + s * tile_boxes + t;
      store(size, load(size) * slack);
    }
  }
}

// cubic[d, e g] += factor_d (p . dx)(q . dx)'s coefficient of dx_e dx_g, e <= g.
inline void add_cubic(double* cubic, const double* factor, const double* p, const double* q, ptrdiff_t n) {
  for (ptrdiff_t e = 0; e < n; ++e) {
    const Lanes pe = load(p + e * tile_boxes), qe = load(q + e * tile_boxes);
    for (ptrdiff_t g = e; g < n; ++g, cubic += tile_boxes) {
      const Lanes straight = pe * load(q + g * tile_boxes);
      const Lanes product = g == e ? straight : straight + qe * load(p + g * tile_boxes);
      double* entry = cubic;
      for (ptrdiff_t d = 0; d < n; ++d, entry += n * (n + 1) / 2 * tile_boxes)
        store(entry, load(entry) + load(factor + d * tile_boxes) * product);
    }
  }
}

// Above |u^2 - line^2| and |u^3 - line^3| for u = z - z0.
inline Lanes square_error(const Reach& u) { return u.deviation * (u.line + u.radius); }
inline Lanes cube_error(const Reach& u) {
  return u.deviation * (u.radius * u.radius + u.radius * u.line + u.line * u.line);
}

// The adjoint of an output: at the centre, and its slopes [n].
struct Adjoint {
  Adjoint(const double* row, const double* half, ptrdiff_t n)
      : value(load(row)), slope(row + tile_boxes), size(magnitude(value)), tilt(spread(slope, half, n)) {}
  Lanes value;
  const double* slope;
  Lanes size, tilt;  // |value| and above |slope . dx|
};

// What the sweep adds up.
struct Sums {
  Lanes remainder, terms;
};

// alpha (sigma(z) - its line), alpha an affine function of dx. With u = z - z0 = line + deviation this is
//   alpha (first deviation + second u^2 / 2 + third u^3 / 6 + rest),
// of which alpha_0 second line deviation, too, is left to the layers below.
inline void pull_value(const Adjoint& alpha, const Reach& u, const double* kept, Sums& sums) {
  const Lanes first = magnitude(load(kept)), second = magnitude(load(kept + tile_boxes)),
              third = magnitude(load(kept + 2 * tile_boxes));
  const Lanes square = u.line * u.line;
  sums.remainder +=
      (alpha.size + alpha.tilt) * (load(kept + 4 * tile_boxes) + twice * first * u.line) +
      0.5 * second * (alpha.size * u.deviation * u.deviation + alpha.tilt * square_error(u)) +
      (1.0 / 6.0) * third * (alpha.size * cube_error(u) + alpha.tilt * u.radius * u.radius * u.radius);
  sums.terms += square * (second * (alpha.size + alpha.tilt) + third * alpha.size * u.line);
}

// rho (sigma'(z) zdot - its line) in the same way: with v = zdot - zdot0 it is
//   rho (first deviation_v + second zdot0 deviation_u + second u v + third (zdot0 u^2 / 2 + u^2 v / 2)
//        + fourth (zdot0 + v) u^3 / 6 + rest (zdot0 + v)),
// of which rho_0 second (line_u deviation_v + line_v deviation_u) and rho_0 third zdot0 line_u deviation_u are left.
inline void pull_rate(const Adjoint& rho, const Reach& u, const Reach& v, Lanes rate0, const double* kept,
                      Sums& sums) {
  const Lanes first = magnitude(load(kept)), second = magnitude(load(kept + tile_boxes)),
              third = magnitude(load(kept + 2 * tile_boxes)), fourth = magnitude(load(kept + 3 * tile_boxes));
  const Lanes rate = magnitude(rate0), square = u.line * u.line, cube = u.radius * u.radius * u.radius;
  sums.remainder +=
      (rho.size + rho.tilt) * (load(kept + 5 * tile_boxes) * (rate + v.radius) +
                               twice * (first * (rate + v.line) + second * rate * u.line)) +
      rho.size * (second * u.deviation * v.deviation + 0.5 * third * rate * u.deviation * u.deviation +
                  0.5 * third * (square_error(u) * v.radius + square * v.deviation) +
                  (1.0 / 6.0) * fourth * (rate * cube_error(u) + cube * v.radius)) +
      rho.tilt * (second * (u.deviation * v.radius + u.line * v.deviation) +
                  0.5 * third * (rate * square_error(u) + u.radius * u.radius * v.radius) +
                  (1.0 / 6.0) * fourth * cube * (rate + v.radius));
  sums.terms += second * u.line * v.line * (2.0 * rho.size + rho.tilt) +
                square * (third * (rate * (rho.size + rho.tilt) + rho.size * v.line) +
                          fourth * rate * rho.size * u.line);
}

void pull_back(const LayerTile& layer, const PullBackTile& tile) {
  const ptrdiff_t n = layer.dimension, block = (1 + n + n * (n + 1) / 2) * tile_boxes;
  const ptrdiff_t row = layer.streams * block, adjoint_row = (1 + n) * tile_boxes;
  double* const factor = tile.scratch;
  for (ptrdiff_t t = 0; t < tile_boxes; t += lanes<double>) {
    const double* half = layer.half + t;
    Sums sums = {load(tile.remainder + t), load(tile.magnitude + t)};
    for (ptrdiff_t i = 0; i < layer.width; ++i) {
      const ptrdiff_t at = i * layer.streams * adjoint_row + t;
      const double *z = layer.z + i * row + t, *z_slope = z + tile_boxes,
                   *kept = layer.expansion + i * kept_rows * tile_boxes + t,
                   *r = layer.z_remainder + i * layer.streams * tile_boxes + t;
      const Lanes first = load(kept), second = load(kept + tile_boxes), third = load(kept + 2 * tile_boxes);
      const Reach u(z, load(r), half, n);
      const Adjoint alpha(tile.adjoint_a + at, half, n);
      double* passed = tile.adjoint_z + at;
      pull_value(alpha, u, kept, sums);
      // What weighs line_u^2 / 2, and line_u^3 / 6.
      Lanes curvature = alpha.value * second, twist = alpha.value * third;
      Lanes value_passed = alpha.value * first;
      Lanes passed_size = magnitude(first) * (alpha.size + alpha.tilt) + magnitude(curvature) * u.line;
      if (layer.streams == 2) {
        const double *rate = z + block, *rate_slope = rate + tile_boxes;
        const Reach v(rate, load(r + tile_boxes), half, n);
        const Adjoint rho(tile.adjoint_a + at + adjoint_row, half, n);
        const Lanes rate0 = load(rate);
        pull_rate(rho, u, v, rate0, kept, sums);
        const Lanes mixed = rho.value * second, turn = rho.value * third, bend = turn * rate0,
                    cross = second * rate0, hook = third * rate0;
        curvature += bend;
        twist += rho.value * load(kept + 3 * tile_boxes) * rate0;
        value_passed += rho.value * cross;
        passed_size +=
            magnitude(cross) * (rho.size + rho.tilt) + magnitude(bend) * u.line + magnitude(mixed) * v.line;
        add_product(tile.hessian + t, 2.0 * mixed, z_slope, rate_slope, n);
        double* rate_passed = passed + adjoint_row;
        store(rate_passed, rho.value * first);
        for (ptrdiff_t d = 0; d < n; ++d) {
          const ptrdiff_t to = (1 + d) * tile_boxes;
          const Lanes a = load(alpha.slope + d * tile_boxes), b = load(rho.slope + d * tile_boxes),
                      l = load(z_slope + d * tile_boxes), m = load(rate_slope + d * tile_boxes);
          store(passed + to, first * a + cross * b + curvature * l + mixed * m);
          store(rate_passed + to, first * b + mixed * l);
          store(factor + d * tile_boxes, 0.5 * (second * a + hook * b + turn * m) + (1.0 / 6.0) * twist * l);
          store(factor + (n + d) * tile_boxes, second * b);
        }
        add_cubic(tile.cubic + t, factor + n * tile_boxes, z_slope, rate_slope, n);
        const Lanes rate_size = magnitude(first) * (rho.size + rho.tilt) + magnitude(mixed) * u.line;
        sums.remainder += rate_size * (layer.row_error[i] * load(layer.magnitude_in + tile_boxes + t) +
                                       layer.adjoint_rounding * v.deviation);
      } else {
        for (ptrdiff_t d = 0; d < n; ++d) {
          const Lanes a = load(alpha.slope + d * tile_boxes), l = load(z_slope + d * tile_boxes);
          store(passed + (1 + d) * tile_boxes, first * a + curvature * l);
          store(factor + d * tile_boxes, 0.5 * second * a + (1.0 / 6.0) * twist * l);
        }
      }
      store(passed, value_passed);
      add_square(tile.hessian + t, curvature, z_slope, n);
      add_cubic(tile.cubic + t, factor, z_slope, z_slope, n);
      sums.remainder += passed_size * (layer.row_error[i] * load(layer.magnitude_in + t) +
                                       layer.bias_error[i] + layer.adjoint_rounding * u.deviation);
    }
    store(tile.remainder + t, sums.remainder);
    store(tile.magnitude + t, sums.terms);
  }
}

}  // namespace

extern const TaylorKernels taylor_kernels;
const TaylorKernels taylor_kernels = {expand, activate, pull_back};

}  // namespace s2nnds::S2NNDS_KERNEL_SPACE
