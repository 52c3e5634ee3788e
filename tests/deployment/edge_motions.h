// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// For programs that attack an exported header: included with POLICY_HEADER and POLICY_NAMESPACE set.

#include <cmath>
#include <random>

#include POLICY_HEADER

namespace policy = POLICY_NAMESPACE;

constexpr int n = policy::dimension;

struct Place {
  double x[n];
};

inline std::mt19937_64 engine;
inline double uniform(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(engine);
}

inline double dot(const Place& a, const Place& b) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += a.x[i] * b.x[i];
  return sum;
}

// The unit vector along the barrier's gradient.
inline Place normal(const Place& p) {
  Place g{};
  const double step = 1e-6 * policy::position_scale;
  for (int i = 0; i < n; ++i) {
    Place above = p, below = p;
    above.x[i] += step;
    below.x[i] -= step;
    g.x[i] = policy::barrier(above.x) - policy::barrier(below.x);
  }
  const double size = std::sqrt(dot(g, g));
  for (double& value : g.x) value /= size;
  return g;
}

inline Place direction() {
  Place d{};
  for (double& value : d.x) value = std::normal_distribution<double>()(engine);
  const double size = std::sqrt(dot(d, d));
  for (double& value : d.x) value /= size;
  return d;
}

// A place in {B <= 0}, nearer to its edge, along a ray from the goal, than 1e-3 (normalised).
inline Place start_at_the_edge() {
  Place p{};
  const Place ray = direction();
  double low = 0, high = HUGE_VAL;  // up to the workspace's edge, where the barrier is positive
  for (int i = 0; i < n; ++i) {
    const double side = policy::workspace[ray.x[i] > 0 ? n + i : i] - policy::goal[i];
    if (ray.x[i] != 0) high = std::fmin(high, side / ray.x[i]);
  }
  const auto along_ray = [&](double length) {
    for (int i = 0; i < n; ++i) p.x[i] = policy::goal[i] + length * ray.x[i];
  };
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    along_ray(middle);
    (policy::barrier(p.x) <= 0 ? low : high) = middle;
  }
  along_ray(low - 1e-3 * policy::position_scale * uniform(0, 1));
  return p;
}
