// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/interval.h"

#include <initializer_list>

namespace s2nnds {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double largest = std::numeric_limits<double>::max();

// Bounds of the exact value of which the C library returned `value`: 4 units in the last place are at most
// 2^-50 |value|, and 4 denormal steps below the normal numbers; 2^-49 and 8 leave room for rounding the
// bounds.
double library_down(double value) {
  if (value == infinity) return largest;  // overflow: the exact value may still be finite
  constexpr double tiny = 8 * std::numeric_limits<double>::denorm_min();
  return next_down(value - (std::abs(value) * 0x1p-49 + tiny));
}
double library_up(double value) { return -library_down(-value); }

Interval increasing(const Interval& a, double (*function)(double), double least, double greatest) {
  if (!a.is_defined()) return Interval::undefined();
  return {std::max(least, library_down(function(a.lower))),
          std::min(greatest, library_up(function(a.upper)))};
}

// Whether `a` may hold a point offset + k period with k an integer.
bool may_hold(const Interval& a, const Interval& offset, const Interval& period) {
  const Interval k = (a - offset) / period;
  return !(std::ceil(k.lower) > std::floor(k.upper));
}

Interval twice(const Interval& a) { return {2.0 * a.lower, 2.0 * a.upper}; }
Interval half(const Interval& a) { return {0.5 * a.lower, 0.5 * a.upper}; }

// sin or cos, whose maxima lie at `peak` and whose minima lie at `peak` + pi, modulo 2 pi.
Interval wave(const Interval& a, double (*function)(double), const Interval& peak) {
  if (!a.is_defined()) return Interval::undefined();
  if (!(a.magnitude() < infinity)) return {-1.0, 1.0};
  const Interval period = twice(pi_interval());
  const double left = function(a.lower), right = function(a.upper);
  Interval result(-1.0, 1.0);
  if (!may_hold(a, peak, period)) result.upper = std::min(1.0, library_up(std::max(left, right)));
  if (!may_hold(a, peak + pi_interval(), period)) {
    result.lower = std::max(-1.0, library_down(std::min(left, right)));
  }
  return result;
}

// x^e for x >= 0 at one corner, as a limit where an argument is infinite.
double corner(double base, double exponent) {
  return base == 0.0 && exponent == 0.0 ? 1.0 : std::pow(base, exponent);
}

}  // namespace

Interval pi_interval() {
  constexpr double below = 3.141592653589793;  // the double nearest to pi is below it
  return {below, next_up(below)};
}

Interval operator/(const Interval& a, const Interval& b) {
  if (!a.is_defined() || !b.is_defined()) return Interval::undefined();
  if (b.contains(0.0)) return Interval::undefined();
  double low = infinity, high = -infinity;
  for (double numerator : {a.lower, a.upper}) {
    for (double denominator : {b.lower, b.upper}) {
      // infinity / infinity: the limit along the finite numerators is 0, along the finite denominators
      // infinite.
      const double quotient = std::isinf(denominator) ? 0.0 : numerator / denominator;
      low = std::min(low, quotient);
      high = std::max(high, quotient);
    }
  }
  Interval result(next_down(low), next_up(high));
  const bool nonnegative = (a.lower >= 0.0 && b.lower > 0.0) || (a.upper <= 0.0 && b.upper < 0.0);
  const bool nonpositive = (a.lower >= 0.0 && b.upper < 0.0) || (a.upper <= 0.0 && b.lower > 0.0);
  if (nonnegative) result.lower = std::max(result.lower, 0.0);
  if (nonpositive) result.upper = std::min(result.upper, 0.0);
  return result;
}

Interval intersection(const Interval& a, const Interval& b) {
  if (!a.is_defined() || !b.is_defined()) return Interval::undefined();
  return {std::max(a.lower, b.lower), std::min(a.upper, b.upper)};
}

Interval hull(const Interval& a, const Interval& b) {
  if (!a.is_defined() || !b.is_defined()) return Interval::undefined();
  return {std::min(a.lower, b.lower), std::max(a.upper, b.upper)};
}

Interval min(const Interval& a, const Interval& b) {
  if (!a.is_defined() || !b.is_defined()) return Interval::undefined();
  return {std::min(a.lower, b.lower), std::min(a.upper, b.upper)};
}

Interval max(const Interval& a, const Interval& b) { return -min(-a, -b); }

Interval abs(const Interval& a) {
  if (!a.is_defined()) return Interval::undefined();
  return {std::max(0.0, std::max(a.lower, -a.upper)), a.magnitude()};
}

Interval square(const Interval& a) {
  const Interval m = abs(a);
  return m * m;
}

Interval sqrt(const Interval& a) {
  if (!a.is_defined() || !(a.lower >= 0.0)) return Interval::undefined();
  return {std::max(0.0, next_down(std::sqrt(a.lower))), next_up(std::sqrt(a.upper))};
}

Interval exp(const Interval& a) { return increasing(a, std::exp, 0.0, infinity); }

Interval log(const Interval& a) {
  if (!(a.lower > 0.0)) return Interval::undefined();
  return increasing(a, std::log, -infinity, infinity);
}

Interval tanh(const Interval& a) { return increasing(a, std::tanh, -1.0, 1.0); }

Interval sin(const Interval& a) { return wave(a, std::sin, half(pi_interval())); }

Interval cos(const Interval& a) { return wave(a, std::cos, 0.0); }

Interval tan(const Interval& a) {
  if (!a.is_defined()) return Interval::undefined();
  if (!(a.magnitude() < infinity) || may_hold(a, half(pi_interval()), pi_interval())) {
    return Interval::undefined();
  }
  return increasing(a, std::tan, -infinity, infinity);
}

Interval power(const Interval& base, int exponent) {
  if (!base.is_defined()) return Interval::undefined();
  if (exponent < 0) return Interval(1.0) / power(base, -exponent);
  if (exponent == 0) return 1.0;
  if (exponent == 1) return base;
  if (exponent == 2) return square(base);
  if (exponent % 2 == 0) return power(abs(base), Interval(exponent));
  const double low = std::pow(base.lower, exponent), high = std::pow(base.upper, exponent);
  Interval result(library_down(low), library_up(high));
  if (base.lower >= 0.0) result.lower = std::max(result.lower, 0.0);
  if (base.upper <= 0.0) result.upper = std::min(result.upper, 0.0);
  return result;
}

Interval power(const Interval& base, const Interval& exponent) {
  if (!base.is_defined() || !exponent.is_defined() || !(base.lower >= 0.0)) return Interval::undefined();
  if (base.lower == 0.0 && exponent.lower < 0.0) return Interval::undefined();
  // For x >= 0 the power is monotone in the base and in the exponent, so that its extremes are at the
  // corners.
  double low = infinity, high = 0.0;
  for (double x : {base.lower, base.upper}) {
    for (double e : {exponent.lower, exponent.upper}) {
      const double value = corner(x, e);
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  // 0^e jumps at e = 0.
  if (base.lower == 0.0 && exponent.lower == 0.0) {
    low = exponent.upper > 0.0 ? 0.0 : std::min(low, 1.0);
    high = std::max(high, 1.0);
  }
  return {std::max(0.0, library_down(low)), library_up(high)};
}

}  // namespace s2nnds
