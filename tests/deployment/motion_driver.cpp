// SPDX-License-Identifier: BSD-3-Clause
// Compiled by robot_test with POLICY_HEADER and POLICY_NAMESPACE set. Sampled motions of the header's own velocity from
// starts at the edge of the safe set, as the execution model allows them: commands are held, and of the readings that are
// late, off or rounded, that counts whose command points outwards the most; the arm errs outwards.
// Arguments: motions, period, delay, position error, velocity error, its relative part, how many times these, seed.
// Prints how many motions left, and the largest B.
#include <cstdio>
#include <cstdlib>

#include "edge_motions.h"

namespace {

struct Model {
  double period, delay, position_error, velocity_error, relative;
};

constexpr int substeps = 4, steps = 10;  // of a period, and periods a motion

class Motion {
 public:
  Motion(const Model& model, const Place& start) : model_(model), p_(start) { past_[0] = start; }

  // The largest B at its substeps, until it leaves.
  double largest_barrier() {
    double largest = -HUGE_VAL;
    for (int step = 0; step < steps && !(largest > 0); ++step) {
      const Place outwards = normal(p_), u = command(outwards);
      const double noise = model_.velocity_error + model_.relative * std::sqrt(dot(u, u));
      for (int k = 0; k < substeps; ++k) {
        for (int i = 0; i < n; ++i) p_.x[i] += model_.period / substeps * (u.x[i] + noise * outwards.x[i]);
        past_[known_++] = p_;
        largest = std::fmax(largest, policy::barrier(p_.x));
      }
    }
    return largest;
  }

 private:
  // The place a number of substeps ago; before the start it is the start.
  const Place& seen(int age) const { return past_[age < known_ ? known_ - 1 - age : 0]; }
  // To a grid so coarse as the error allows.
  Place rounded(const Place& y) const {
    const double step = 2 * model_.position_error / std::sqrt(n);
    Place grid = y;
    if (step > 0) {
      for (double& value : grid.x) value = step * std::round(value / step);
    }
    return grid;
  }
  Place off(const Place& y, const Place& along) const {
    Place moved = y;
    for (int i = 0; i < n; ++i) moved.x[i] += model_.position_error * along.x[i];
    return moved;
  }
  Place command(const Place& outwards) const {
    const int oldest = static_cast<int>(model_.delay / model_.period * substeps + 1e-9);
    Place best{};
    double farthest = -HUGE_VAL;
    const auto attempt = [&](const Place& y) {
      Place u{};
      policy::velocity(y.x, u.x);
      for (double& value : u.x) value *= policy::execution_speed;
      if (const double speed = dot(u, outwards); speed > farthest) {
        farthest = speed;
        best = u;
      }
    };
    for (const int age : {0, oldest, static_cast<int>(uniform(0, oldest + 0.999))}) {
      attempt(rounded(seen(age)));
      attempt(off(seen(age), outwards));
      attempt(off(seen(age), direction()));
    }
    return best;
  }

  Model model_;
  Place p_, past_[steps * substeps + 1];
  int known_ = 1;
};

}  // namespace

int main(int, char** arguments) {
  static_assert(policy::executed == 1);
  const long motions = std::atol(arguments[1]);
  const double times = std::atof(arguments[7]);
  const Model model = {std::atof(arguments[2]), times * std::atof(arguments[3]),
                       times * std::atof(arguments[4]), times * std::atof(arguments[5]),
                       times * std::atof(arguments[6])};
  engine.seed(std::strtoul(arguments[8], nullptr, 10));
  long left = 0;
  double largest = -HUGE_VAL;
  for (long k = 0; k < motions; ++k) {
    const double barrier = Motion(model, start_at_the_edge()).largest_barrier();
    left += !(barrier <= 0);
    largest = std::fmax(largest, barrier);
  }
  std::printf("%ld %g\n", left, largest);
  return 0;
}
