// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/simplex.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace s2nnds {
namespace {

// Weights of the second and the third vertex; with that of the first they are >= 0 and sum to 1.
struct Weights {
  double second = 0.0, third = 0.0;
};

// The point of a segment nearest to x, up to rounding.
double nearest_on_segment(const Position& a, const Position& b, const Position& x) {
  const Position along = b - a;
  const double t = along.dot(x - a) / along.squaredNorm();
  return t >= 0.0 ? std::min(t, 1.0) : 0.0;  // 0 for a segment without length
}

// The point of a triangle nearest to x, up to rounding: inside, by the normal equations, else on a side.
Weights nearest_on_triangle(const std::array<Position, 3>& v, const Position& x) {
  const Position e = v[1] - v[0], f = v[2] - v[0], d = x - v[0];
  const double ee = e.squaredNorm(), ff = f.squaredNorm(), ef = e.dot(f), ed = e.dot(d), fd = f.dot(d);
  const double area = ee * ff - ef * ef;
  const double s = (ff * ed - ef * fd) / area, t = (ee * fd - ef * ed) / area;
  if (s >= 0.0 && t >= 0.0 && s + t <= 1.0) {
    // Rounding must not carry the point out of the triangle.
    return {s, std::max(0.0, std::min(t, (1.0 - s) - 0x1p-52))};
  }
  const double on_e = nearest_on_segment(v[0], v[1], x), on_f = nearest_on_segment(v[0], v[2], x);
  const double on_g = nearest_on_segment(v[1], v[2], x);
  const double from_e = (x - (v[0] + on_e * e)).squaredNorm();
  const double from_f = (x - (v[0] + on_f * f)).squaredNorm();
  const double from_g = (x - (v[1] + on_g * (v[2] - v[1]))).squaredNorm();
  if (from_e <= from_f && from_e <= from_g) return {on_e, 0.0};
  if (from_f <= from_g) return {0.0, on_f};
  const double third = std::max(0.0, on_g - 0x1p-52);
  return {std::max(0.0, 1.0 - on_g), third};  // rounds to at most 1 - third
}

Weights nearest(const Simplex& simplex, const Position& x) {
  if (simplex.count == 1) return {};
  if (simplex.count == 2) return {nearest_on_segment(simplex.vertex[0], simplex.vertex[1], x), 0.0};
  return nearest_on_triangle(simplex.vertex, x);
}

// x minus the point of those weights, by `Number`, which are doubles or intervals.
template <typename Number>
Number offset(const Simplex& simplex, const Weights& weight, const Position& x, Eigen::Index i) {
  Number to = Number(x[i]) - Number(simplex.vertex[0][i]);
  if (simplex.count > 1 && weight.second != 0.0) {
    to = to - Number(weight.second) * (Number(simplex.vertex[1][i]) - Number(simplex.vertex[0][i]));
  }
  if (simplex.count > 2 && weight.third != 0.0) {
    to = to - Number(weight.third) * (Number(simplex.vertex[2][i]) - Number(simplex.vertex[0][i]));
  }
  return to;
}

// At most the distance between the simplex and a box on the other side of it along `direction`, any vector:
// how far the box's farthest face lies beyond the simplex's farthest vertex.
double separation(const Simplex& simplex, const Position& direction, const Position& center,
                  const Position& half_widths) {
  Interval squares = 0.0, reach = 0.0;
  for (Eigen::Index i = 0; i < direction.size(); ++i) {
    squares += square(Interval(direction[i]));
    if (half_widths[i] > 0.0) reach += Interval(std::abs(direction[i])) * Interval(half_widths[i]);
  }
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < simplex.count; ++k) {
    Interval along = 0.0;
    for (Eigen::Index i = 0; i < direction.size(); ++i) {
      along +=
          Interval(direction[i]) * (Interval(center[i]) - simplex.vertex[static_cast<std::size_t>(k)][i]);
    }
    least = std::min(least, along.lower);
  }
  const Interval beyond = Interval(least) - reach;
  if (!(beyond.lower > 0.0) || !(squares.lower > 0.0)) return 0.0;
  return (Interval(beyond.lower) / sqrt(squares)).lower;
}

}  // namespace

Interval Simplex::distance(const Position& x) const {
  const Weights weight = nearest(*this, x);
  Interval squares = 0.0;
  Position direction(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const Interval to = offset<Interval>(*this, weight, x, i);
    direction[i] = 0.5 * to.lower + 0.5 * to.upper;
    squares += square(to);
  }
  // A point of the simplex bounds the distance from above, a plane between it and x from below.
  const double lower = separation(*this, direction, x, Position::Zero(x.size()));
  const double upper = sqrt(squares).upper;
  return {std::min(lower, upper), upper};
}

double Simplex::rounded_distance(const Position& x) const {
  const Weights weight = nearest(*this, x);
  double squares = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double to = offset<double>(*this, weight, x, i);
    squares += to * to;
  }
  return std::sqrt(squares);
}

double Simplex::gap(const Position& center, const Position& half_widths) const {
  const Weights weight = nearest(*this, center);
  Position direction(center.size());
  for (Eigen::Index i = 0; i < center.size(); ++i) {
    direction[i] = offset<double>(*this, weight, center, i);
  }
  return separation(*this, direction, center, half_widths);
}

Interval box_distance(const Position& lower, const Position& upper, const Position& other_lower,
                      const Position& other_upper) {
  Interval squares = 0.0;
  for (Eigen::Index i = 0; i < lower.size(); ++i) {
    if (lower[i] > other_upper[i]) squares += square(Interval(lower[i]) - other_upper[i]);
    if (other_lower[i] > upper[i]) squares += square(Interval(other_lower[i]) - upper[i]);
  }
  return squares.upper == 0.0 ? squares : sqrt(squares);  // exactly 0 where they meet
}

double rounded_squared_distance(const Position& lower, const Position& upper, const Position& other_lower,
                                const Position& other_upper) {
  double squares = 0.0;
  for (Eigen::Index i = 0; i < lower.size(); ++i) {
    const double gap = std::max({lower[i] - other_upper[i], other_lower[i] - upper[i], 0.0});
    squares += gap * gap;
  }
  return squares;
}

double least_squared_distance(const Position& lower, const Position& upper, const Position& other_lower,
                              const Position& other_upper) {
  // Each difference, product and sum is wrong by 2^-53 of itself at most, below the normal numbers by 2^-1074;
  // past the largest number, the exact square is beyond half of it, too.
  constexpr double largest = std::numeric_limits<double>::max();
  const double squares = rounded_squared_distance(lower, upper, other_lower, other_upper);
  return std::min(squares, largest) * (1.0 - 0x1p-40) - 0x1p-1000;
}

double greatest_square(double distance) { return square(Interval(distance)).upper; }

double half_diagonal(const Box& box) {
  Interval squares = 0.0;
  const Vector half_widths = box.half_widths();
  for (const double half_width : half_widths) squares += square(Interval(half_width));
  return sqrt(squares).upper;
}

Interval lipschitz_enclosure(const Interval& at_center, const Box& box) {
  const double reach = half_diagonal(box);
  return at_center + Interval(-reach, reach);
}

}  // namespace s2nnds
