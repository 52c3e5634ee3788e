// SPDX-License-Identifier: BSD-3-Clause
// Compiled with POLICY_HEADER and POLICY_NAMESPACE set, of a policy in the plane with a range of scenes around a ball: follows
// MOTIONS motions from all over the displaced safe sets, the obstacle at the range's edge, every other one on its way around it,
// and prints how many touch the obstacle, how many leave the safe set, how many arrive, how many there were, and the nanoseconds
// that one velocity takes. Arguments: MOTIONS, the obstacle's centre and radius, the goal's radius, and how many times the
// certified disturbance pushes outwards, along the barrier's gradient; such motions are followed for a while.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include POLICY_HEADER

namespace {
namespace policy = POLICY_NAMESPACE;
static_assert(policy::dimension == 2 && policy::displaced_places == 2);

// Where the obstacle is at time t, and how it moves; `turn` in rad/s, 0: it rests.
struct Path {
  double angle, turn, push;  // push: of the disturbance, in `unit` per second
  void at(double t, double* p, double* rate) const {
    const double radius = 0.999999 * policy::displacement_radius, now = angle + turn * t;
    p[0] = radius * std::cos(now);
    p[1] = radius * std::sin(now);
    rate[0] = -turn * p[1];
    rate[1] = turn * p[0];
  }
  void velocity(double t, const double* x, double* v) const {
    double p[2], rate[2];
    at(t, p, rate);
    policy::velocity(x, p, rate, v);
    if (push == 0.0) return;
    double gradient[2], size = 0.0;
    for (int i = 0; i < 2; ++i) {
      const double h = 1e-6 * policy::position_scale;
      double more[2] = {x[0], x[1]}, less[2] = {x[0], x[1]};
      more[i] += h;
      less[i] -= h;
      gradient[i] = policy::barrier(more, p) - policy::barrier(less, p);
      size += gradient[i] * gradient[i];
    }
    for (int i = 0; i < 2; ++i) v[i] += push * gradient[i] / std::sqrt(std::fmax(size, 1e-300));
  }
};

// A step of the classical Runge-Kutta method.
void advance(const Path& path, double t, double h, double* x) {
  double k[4][2], y[2];
  path.velocity(t, x, k[0]);
  for (int i = 0; i < 2; ++i) y[i] = x[i] + 0.5 * h * k[0][i];
  path.velocity(t + 0.5 * h, y, k[1]);
  for (int i = 0; i < 2; ++i) y[i] = x[i] + 0.5 * h * k[1][i];
  path.velocity(t + 0.5 * h, y, k[2]);
  for (int i = 0; i < 2; ++i) y[i] = x[i] + h * k[2][i];
  path.velocity(t + h, y, k[3]);
  for (int i = 0; i < 2; ++i) x[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
}
}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) return 2;
  const long motions = std::atol(argv[1]);
  const double center[2] = {std::atof(argv[2]), std::atof(argv[3])}, radius = std::atof(argv[4]),
               near = std::atof(argv[5]), push = std::atof(argv[6]) * policy::displaced_disturbance_margin;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double period = policy::position_scale / policy::velocity_scale, step = 0.02 * period;
  long touched = 0, left = 0, arrived = 0, calls = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (long k = 0; k < motions; ++k) {
    const Path path{6.2831853 * unit(random), k % 2 == 0 ? 0.0 : (unit(random) - 0.5) / period, push};
    double x[2], p[2], rate[2];
    path.at(0.0, p, rate);
    do {
      for (int i = 0; i < 2; ++i)
        x[i] = policy::workspace[i] + unit(random) * (policy::workspace[2 + i] - policy::workspace[i]);
      // Half of them from beside the obstacle, where the range is put to use.
      if (k % 4 < 2)
        for (int i = 0; i < 2; ++i) x[i] = center[i] + p[i] + 4.0 * radius * (2.0 * unit(random) - 1.0);
    } while (!policy::safe(x, p));
    bool out = false, met = false;
    for (int round = 0; round < (push > 0.0 ? 300 : 5000); ++round) {
      const double t = round * step;
      advance(path, t, step, x);
      calls += 4;
      path.at(t + step, p, rate);
      if (std::hypot(x[0] - center[0] - p[0], x[1] - center[1] - p[1]) <= radius) met = true;
      if (!(policy::barrier(x, p) <= 1e-5)) out = true;  // a step of the method is not exact
      if (std::hypot(x[0] - policy::goal[0], x[1] - policy::goal[1]) <= near) {
        ++arrived;
        break;
      }
    }
    touched += met;
    left += out;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  // The velocity alone, at places all over.
  double sum = 0.0;
  const auto start = std::chrono::steady_clock::now();
  for (int k = 0; k < 200000; ++k) {
    const double p[2] = {0.7 * policy::displacement_radius, -0.6 * policy::displacement_radius};
    const double x[2] = {center[0] + 1e-5 * k * radius, center[1] + p[1] - 1e-5 * k * radius};
    double v[2];
    policy::velocity(x, p, v);
    sum += v[0];
  }
  const double one = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / 200000;
  std::printf("%ld %ld %ld %ld %.1f %.1f %g\n", touched, left, arrived, motions, 1e9 * one, seconds, sum);
  return 0;
}
