// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "s2nnds/core/random.h"
#include "s2nnds/problem/region.h"
#include "s2nnds/problem/simplex.h"

namespace s2nnds {

// What a region's level is compared with: the exact level, by another way, up to rounding.
using Reference = std::function<double(const Vector&)>;

inline Box random_box(RandomStream& random, const Box& around, double largest) {
  Box box = around;
  const double size = largest * std::pow(10.0, random.uniform(-4.0, 0.0));
  for (Eigen::Index i = 0; i < around.dimension(); ++i) {
    box.lower[i] = random.uniform(around.lower[i], around.upper[i]);
    box.upper[i] = box.lower[i] + size * random.uniform(0.0, 1.0);
  }
  return box;
}

// Random boxes against the reference at random points of them, at their corners and near their centres:
// verdicts and enclosures must hold, and boxes that are 2 % of their half diagonal away must be decided.
inline void attack(const RegionPtr& region, const Box& around, const Reference& exact, int boxes,
                   double tolerance = 1e-12) {
  RandomStream random(7, "attack");
  int inside = 0, outside = 0;
  for (int k = 0; k < boxes; ++k) {
    const Box box = random_box(random, around, 0.3 * (around.upper - around.lower).maxCoeff());
    const Location location = region->classify(box);
    const Interval bound = region->enclosure(box);
    inside += location == Location::inside;
    outside += location == Location::outside;
    Points x(16, box.dimension());
    for (Eigen::Index row = 0; row < x.rows(); ++row) {
      for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const bool corner = row < 8;
        x(row, i) = corner ? ((row >> std::min<Eigen::Index>(i, 2)) % 2 == 0 ? box.lower[i] : box.upper[i])
                           : random.uniform(box.lower[i], box.upper[i]);
      }
      const double level = exact(x.row(row).transpose());
      ASSERT_FALSE(location == Location::inside && level > tolerance) << region->describe() << " " << level;
      ASSERT_FALSE(location == Location::outside && level < -tolerance) << region->describe() << " " << level;
      ASSERT_LE(level, bound.upper + tolerance) << region->describe();
      ASSERT_GE(level, bound.lower - tolerance) << region->describe();
      ASSERT_NEAR(region->level(x.row(row))[0], level, tolerance)
          << region->describe() << " at " << x.row(row);
    }
    if (std::abs(exact(box.center())) > 1.02 * half_diagonal(box)) {
      ASSERT_NE(location, Location::unknown) << region->describe();
    }
  }
  EXPECT_GT(inside, boxes / 50) << region->describe();
  EXPECT_GT(outside, boxes / 50) << region->describe();
}

// What the Error of `make` says; empty where there is none.
template <typename Make>
std::string message_of(const Make& make) {
  try {
    make();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

inline void expect_message(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << "'" << message << "' lacks '" << part << "'";
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

// Makes a region from TOML, as a configuration has it.
inline RegionPtr region_of(const std::string& toml, Eigen::Index dimension,
                           RegionFiles files = RegionFiles()) {
  RegionOptions options;
  read_toml(toml, "test", options);
  return make_region(options, dimension, files, "region");
}

// The signed distance from the polygon of these corners, by the angles under which its edges are seen.
inline double polygon_distance(const Points& corners, const Vector& x) {
  double least = 1e300, angle = 0.0;
  for (Eigen::Index k = 0; k < corners.rows(); ++k) {
    const Eigen::Vector2d a = corners.row(k).transpose() - x;
    const Eigen::Vector2d b = corners.row((k + 1) % corners.rows()).transpose() - x;
    const Eigen::Vector2d e = b - a;
    const double t = std::min(1.0, std::max(0.0, -a.dot(e) / e.squaredNorm()));
    least = std::min(least, (a + t * e).norm());
    angle += std::atan2(a[0] * b[1] - a[1] * b[0], a.dot(b));
  }
  return std::abs(angle) > M_PI ? -least : least;
}

}  // namespace s2nnds
