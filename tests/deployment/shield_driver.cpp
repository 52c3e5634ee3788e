// SPDX-License-Identifier: BSD-3-Clause
// Compiled by shield_test with POLICY_HEADER and POLICY_NAMESPACE set. Motions behind the shield, from starts at the edge
// of the safe set, as the execution model allows them, with wanted velocities, delays and errors that push outwards.
// Arguments: motions, period, delay, position error, velocity error, its relative part, how many times these, seed.
// Prints how many motions left, in how many calls the shield did nothing inside and changed something at the edge, its
// largest change of the motion's own velocity, the nanoseconds of a call, and the allocations during them.
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "counted_allocations.h"
#include "edge_motions.h"

int main(int, char** arguments) {
  static_assert(policy::shielded == 1 && policy::executed == 1);
  static_assert(noexcept(policy::shield(nullptr, nullptr, nullptr)));
  const long motions = std::atol(arguments[1]);
  const double times = std::atof(arguments[7]), period = std::atof(arguments[2]);
  const double delay = times * std::atof(arguments[3]), position_error = times * std::atof(arguments[4]);
  const double velocity_error = times * std::atof(arguments[5]), relative = times * std::atof(arguments[6]);
  engine.seed(std::strtoul(arguments[8], nullptr, 10));
  constexpr int substeps = 4, steps = 12;
  const int oldest = static_cast<int>(delay / period * substeps + 1e-9);
  long left = 0, untouched = 0, changed = 0;
  double largest_own_change = 0;
  static Place past[steps * substeps + 1];
  for (long motion = 0; motion < motions; ++motion) {
    Place p = start_at_the_edge();
    past[0] = p;
    std::size_t known = 1;
    bool out = false;
    for (int step = 0; step < steps && !out; ++step) {
      const Place outwards = normal(p);
      // The reading and the wish, of a few, whose command points outwards the most.
      Place best{};
      double farthest = -1e300, size = 0;
      for (int attempt = 0; attempt < 6; ++attempt) {
        const auto age = static_cast<std::size_t>(attempt % 2 == 0 ? oldest : uniform(0, oldest + 0.999));
        Place y = past[age < known ? known - 1 - age : 0];
        const Place off = attempt < 2 ? outwards : direction();
        for (int i = 0; i < n; ++i) y.x[i] += (attempt == 0 ? -1 : 1) * position_error * off.x[i];
        Place wanted = attempt < 4 ? outwards : direction(), v{};
        const double scale = policy::most_command * std::exp(uniform(-3, 5)), turn = uniform(-1, 1);
        for (int i = 0; i < n; ++i) wanted.x[i] = scale * (wanted.x[i] + turn * off.x[i]);
        policy::shield(y.x, wanted.x, v.x) > 0 ? ++changed : ++untouched;
        if (const double speed = dot(v, outwards); speed > farthest) {
          farthest = speed;
          best = v;
        }
        Place own{};
        policy::velocity(y.x, own.x);
        for (double& value : own.x) value *= policy::execution_speed;
        largest_own_change = std::fmax(largest_own_change, policy::shield(y.x, own.x, v.x));
      }
      for (const double value : best.x) size += value * value;
      const double noise = velocity_error + relative * std::sqrt(size);
      for (int k = 0; k < substeps; ++k) {
        const Place push = normal(p);
        for (int i = 0; i < n; ++i) p.x[i] += period / substeps * (best.x[i] + noise * push.x[i]);
        past[known++] = p;
        out = out || policy::barrier(p.x) > 0;
      }
    }
    left += out;
  }
  // Deep inside nothing happens, whatever is wanted within the limit.
  Place center{}, wanted{}, v{};
  for (int i = 0; i < n; ++i) center.x[i] = policy::goal[i];
  wanted.x[0] = 0.9 * policy::most_command;
  const double inside = policy::shield(center.x, wanted.x, v.x);
  const Place bad{{NAN}};
  const bool stops = policy::shield(bad.x, wanted.x, v.x) == HUGE_VAL && v.x[0] == 0;
  const bool own = policy::shield(center.x, bad.x, v.x) == HUGE_VAL && v.x[0] == 0;  // f vanishes at the goal
  const long before = allocations;
  const auto begin = std::chrono::steady_clock::now();
  constexpr int calls = 20000;
  double sum = 0;
  for (int k = 0; k < calls; ++k) {
    wanted.x[0] = (0.1 + 1e-6 * k) * policy::most_command;
    sum += policy::shield(past[0].x, wanted.x, v.x) + v.x[0];
  }
  const double nanoseconds =
      std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count() / calls;
  std::printf("%ld %ld %ld %g %g %g %ld %d\n", left, untouched, changed, largest_own_change, inside,
              nanoseconds, allocations - before, stops && own && sum == sum);
  return 0;
}
