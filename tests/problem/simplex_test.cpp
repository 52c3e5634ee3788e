// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/simplex.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/random.h"
#include "s2nnds/problem/simplex_set.h"

namespace s2nnds {
namespace {

using Wide = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

// Distance of x from the segment a b in extended precision.
long double to_segment(const Wide& a, const Wide& b, const Wide& x) {
  const long double length = (b - a).squaredNorm();
  const long double t = length > 0.0L ? (x - a).dot(b - a) / length : 0.0L;
  return (x - a - std::min(1.0L, std::max(0.0L, t)) * (b - a)).norm();
}

long double to_triangle(const Wide& a, const Wide& b, const Wide& c, const Wide& x) {
  const Wide e = b - a, f = c - a, d = x - a;
  const long double ee = e.dot(e), ff = f.dot(f), ef = e.dot(f), ed = e.dot(d), fd = f.dot(d);
  const long double area = ee * ff - ef * ef, s = (ff * ed - ef * fd) / area, t = (ee * fd - ef * ed) / area;
  if (s >= 0.0L && t >= 0.0L && s + t <= 1.0L) return (d - s * e - t * f).norm();
  return std::min({to_segment(a, b, x), to_segment(a, c, x), to_segment(b, c, x)});
}

long double exact(const Simplex& s, const Position& x) {
  const auto wide = [](const Position& p) -> Wide { return p.cast<long double>(); };
  if (s.count == 1) return (wide(x) - wide(s.vertex[0])).norm();
  if (s.count == 2) return to_segment(wide(s.vertex[0]), wide(s.vertex[1]), wide(x));
  return to_triangle(wide(s.vertex[0]), wide(s.vertex[1]), wide(s.vertex[2]), wide(x));
}

Position random_position(RandomStream& random, Eigen::Index n, double size) {
  Position x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = random.uniform(-size, size);
  return x;
}

Simplex random_simplex(RandomStream& random, int count, Eigen::Index n) {
  Simplex s;
  s.count = count;
  for (auto& vertex : s.vertex) vertex = random_position(random, n, 1.0);
  return s;
}

TEST(Simplex, DistancesHoldTheExactOnesClosely) {
  RandomStream random(1, "simplex");
  for (int k = 0; k < 30000; ++k) {
    const Eigen::Index n = 2 + k % 3;
    const Simplex s = random_simplex(random, 1 + k % 3, n);
    const Position x = random_position(random, n, std::pow(10.0, random.uniform(-1.0, 2.0)));
    const Interval found = s.distance(x);
    const long double distance = exact(s, x);
    const double slack = n == 2 && s.count == 3 ? 1e-15 : 1e-17;  // of the reference: 0 in a plane triangle
    ASSERT_LE(found.lower, distance + slack) << k;
    ASSERT_GE(found.upper, distance - slack) << k;
    if (n > 2 || s.count < 3) {
      ASSERT_LE(found.upper - found.lower, 1e-12 * (1.0 + found.upper)) << k;
    }
  }
}

TEST(Simplex, FlatAndVanishingOnesAreSound) {
  const Position a = Vector{{0.0, 0.0, 0.0}}, b = Vector{{1.0, 0.0, 0.0}}, c = Vector{{0.3, 0.0, 0.0}};
  RandomStream random(2, "flat");
  for (const Simplex& s :
       {Simplex{{a, b, c}, 3}, Simplex{{a, a, b}, 3}, Simplex{{b, a, a}, 3}, Simplex{{a, b, a}, 3}}) {
    for (int k = 0; k < 500; ++k) {
      const Position x = random_position(random, 3, 2.0);
      const long double distance =
          to_segment(a.cast<long double>(), b.cast<long double>(), x.cast<long double>());
      EXPECT_LE(s.distance(x).lower, distance + 1e-17);
      EXPECT_NEAR(s.distance(x).upper, static_cast<double>(distance), 1e-9);
      EXPECT_GE(s.distance(x).upper, distance - 1e-17);
    }
  }
  const Simplex point{{a, a, a}, 2};
  EXPECT_NEAR(point.distance(b).upper, 1.0, 1e-15);
  EXPECT_EQ(point.distance(a).lower, 0.0);
}

TEST(Simplex, GapsAreAtMostTheDistanceOfAnyPointOfTheBox) {
  RandomStream random(3, "gap");
  for (int k = 0; k < 3000; ++k) {
    const Eigen::Index n = 2 + k % 2;
    const Simplex s = random_simplex(random, 1 + k % 3, n);
    const Position center = random_position(random, n, 2.0),
                   half = random_position(random, n, 0.5).cwiseAbs();
    const double gap = s.gap(center, half);
    for (int j = 0; j < 30; ++j) {
      const Position x = center + half.cwiseProduct(random_position(random, n, 1.0));
      ASSERT_LE(gap, exact(s, x) + 1e-15L);
    }
    // At least the Lipschitz bound.
    ASSERT_GE(gap, static_cast<double>(exact(s, center)) - half.norm() - 1e-12);
  }
}

TEST(SimplexSet, TheTreeFindsTheNearest) {
  RandomStream random(4, "tree");
  for (const int count : {1, 2, 3, 5, 40, 1000}) {
    Points vertices(3 * count, 3);
    Eigen::MatrixXi triangles(count, 3);
    for (int k = 0; k < count; ++k) {
      const Position at = random_position(random, 3, 1.0);
      for (int i = 0; i < 3; ++i) {
        vertices.row(3 * k + i) = (at + random_position(random, 3, 0.1)).transpose();
        triangles(k, i) = 3 * k + i;
      }
    }
    const SimplexSet set(vertices, triangles);
    for (int k = 0; k < 100; ++k) {
      const Position x = random_position(random, 3, 1.5);
      long double least = 1e300L;
      for (int i = 0; i < count; ++i)
        least = std::min(least, exact(set.simplex(static_cast<std::size_t>(i)), x));
      ASSERT_NEAR(set.distance(x).lower, static_cast<double>(least), 1e-12);
      ASSERT_GE(set.distance(x).upper, least - 1e-17L);
    }
  }
}

}  // namespace
}  // namespace s2nnds
