// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace s2nnds {

// Outward rounding without switching the processor's rounding mode: doubles are rounded to nearest (IEEE 754,
// with gradual underflow), then every result moves to the neighbouring double away from the interval.

// The smallest double above x; +infinity and NaN stay.
inline double next_up(double x) {
  if (!(x < std::numeric_limits<double>::infinity())) return x;
  if (x == 0.0) return std::numeric_limits<double>::denorm_min();
  const auto bits = std::bit_cast<std::int64_t>(x);
  return std::bit_cast<double>(x > 0.0 ? bits + 1 : bits - 1);
}
// The largest double below x; -infinity and NaN stay.
inline double next_down(double x) { return -next_up(-x); }

// A closed interval of real numbers that holds the exact value of what was computed. A bound may be infinite.
// Both bounds are NaN where some value is not defined (division by an interval that holds 0, the root of one
// with negative numbers): nothing is known then, and every comparison with it is false.
struct Interval {
  double lower = 0.0;  // <= the exact value
  double upper = 0.0;  // >= the exact value

  constexpr Interval() = default;                                           // [0, 0]
  constexpr Interval(double point) : lower(point), upper(point) {}          // NOLINT: numbers are intervals
  constexpr Interval(double low, double high) : lower(low), upper(high) {}  // [low, high]

  // The one with NaN bounds.
  static constexpr Interval undefined() {
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  }

  bool is_defined() const { return lower <= upper; }  // false for NaN and for an empty interval
  bool is_point() const { return lower == upper; }    // one number only
  bool contains(double x) const { return lower <= x && x <= upper; }               // false for NaN
  double width() const { return next_up(upper - lower); }                          // rounded up
  double magnitude() const { return std::max(std::abs(lower), std::abs(upper)); }  // max |x|
};

namespace interval_detail {
// A sum that rounds to zero is exact.
inline double sum_down(double a, double b) {
  const double sum = a + b;
  return sum == 0.0 ? 0.0 : next_down(sum);
}
// As sum_down, from above.
inline double sum_up(double a, double b) { return -sum_down(-a, -b); }
// The end of an interval may be infinite, its points are not: 0 times infinity is 0 here.
inline double product(double a, double b) { return a == 0.0 || b == 0.0 ? 0.0 : a * b; }
}  // namespace interval_detail

inline Interval operator-(const Interval& a) { return {-a.upper, -a.lower}; }  // exact

// Holds every sum of a point of `a` and a point of `b`, and so on for the operators below; undefined if one
// of them is.
inline Interval operator+(const Interval& a, const Interval& b) {
  return {interval_detail::sum_down(a.lower, b.lower), interval_detail::sum_up(a.upper, b.upper)};
}

inline Interval operator-(const Interval& a, const Interval& b) { return a + (-b); }  // differences

// The sign is exact: a product of numbers >= 0 has no negative lower bound.
inline Interval operator*(const Interval& a, const Interval& b) {
  using interval_detail::product;
  if (!a.is_defined() || !b.is_defined()) return Interval::undefined();
  if (a.lower == 0.0 && a.upper == 0.0) return a;
  if (b.lower == 0.0 && b.upper == 0.0) return b;
  const double p = product(a.lower, b.lower), q = product(a.lower, b.upper);
  const double r = product(a.upper, b.lower), s = product(a.upper, b.upper);
  Interval result(next_down(std::min(std::min(p, q), std::min(r, s))),
                  next_up(std::max(std::max(p, q), std::max(r, s))));
  // The sign is exact even where the product underflows to zero.
  const bool nonnegative = (a.lower >= 0.0 && b.lower >= 0.0) || (a.upper <= 0.0 && b.upper <= 0.0);
  const bool nonpositive = (a.lower >= 0.0 && b.upper <= 0.0) || (a.upper <= 0.0 && b.lower >= 0.0);
  if (nonnegative) result.lower = std::max(result.lower, 0.0);
  if (nonpositive) result.upper = std::min(result.upper, 0.0);
  return result;
}

inline Interval& operator+=(Interval& a, const Interval& b) { return a = a + b; }  // `a` becomes a + b
inline Interval& operator-=(Interval& a, const Interval& b) { return a = a - b; }  // `a` becomes a - b
inline Interval& operator*=(Interval& a, const Interval& b) { return a = a * b; }  // `a` becomes a * b

Interval operator/(const Interval& a, const Interval& b);  // undefined if `b` holds 0

// The values common to two enclosures of the same number; undefined if one of them is.
Interval intersection(const Interval& a, const Interval& b);
// The smallest interval around both; undefined if one of them is.
Interval hull(const Interval& a, const Interval& b);

Interval min(const Interval& a, const Interval& b);  // of a point of each; undefined if one of them is
Interval max(const Interval& a, const Interval& b);  // of a point of each; undefined if one of them is
Interval abs(const Interval& a);                     // of its points
Interval square(const Interval& a);                  // of its points: never negative, unlike a * a
Interval sqrt(const Interval& a);                    // undefined if `a` holds negative numbers

// The functions below rest on one assumption: the C library's exp, log, pow, sin, cos, tan and tanh are wrong
// by at most 4 units in the last place (glibc documents at most 2 for each of them on x86-64 and aarch64).

// Within [0, infinity].
Interval exp(const Interval& a);
Interval log(const Interval& a);                     // undefined unless `a` is positive
Interval sin(const Interval& a);                     // within [-1, 1], also where `a` has infinite bounds
Interval cos(const Interval& a);                     // within [-1, 1], also where `a` has infinite bounds
Interval tan(const Interval& a);                     // undefined if a pole may lie in `a`
Interval tanh(const Interval& a);                    // within [-1, 1]
Interval power(const Interval& base, int exponent);  // undefined if a negative power of 0 may be meant
// Real exponents, 0^0 = 1; undefined if `base` holds negative numbers, or 0 and `exponent` negative ones.
Interval power(const Interval& base, const Interval& exponent);

Interval pi_interval();  // the two doubles around pi

}  // namespace s2nnds
