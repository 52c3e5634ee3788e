// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/conditions/worst_perturbation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/conditions/condition.h"
#include "s2nnds/core/random.h"
#include "s2nnds/problem/region_sampler.h"
#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

ExecutionModel demanding() {
  return {.period = 0.02,
          .delay = 0.03,
          .position_error = 0.02,
          .velocity_error = 0.04,
          .velocity_error_relative = 0.1,
          .field_error = 0.01,
          .least_speed = 0.8,
          .most_speed = 0.8};
}

Vector in_ball(double radius, RandomStream& random) {
  Vector v(2);
  for (double& each : v) each = random.normal();
  return radius * v.normalized();
}

// In a linear field readings are displaced exactly as to first order. The worst of many admissible
// perturbations comes near the estimate; none exceeds it by more than the motion's change of speed on the
// way.
TEST(WorstPerturbation, IsTheWorstOfThoseAdmitted) {
  Points a(2, 2);
  a << -1.0, 2.0, -2.0, -0.5;
  RandomStream random(1, "worst perturbation");
  for (const bool displaces : {true, false}) {
    ExecutionModel model = demanding();
    if (!displaces) model.period = model.delay = model.position_error = 0.0;
    EXPECT_EQ(model.displaces(), displaces);
    const double speed = model.most_speed;
    for (int place = 0; place < 20; ++place) {
      const Vector x = in_ball(0.7, random), f = a * x;
      Vector g = in_ball(3.0, random), delta(2);
      if (g.dot(a * f) > 0.0) g = -g;  // so that the oldest reading is the worst
      const Points jacobian = a;
      worst_perturbation(model, 2, g.data(), f.data(), displaces ? jacobian.data() : nullptr, delta.data());
      const double estimate = g.dot(delta);
      double worst = 0.0;
      for (int k = 0; k < 20000; ++k) {
        const double size = f.norm() + model.field_error;
        const auto noise = [&] {
          return Vector(in_ball(model.velocity_error + speed * model.velocity_error_relative * size, random) +
                        speed * in_ball(model.field_error, random));
        };
        const double age = k % 2 == 0 ? model.window() : model.window() * random.uniform();
        const Vector reading = x - age * (speed * f + noise()) + in_ball(model.position_error, random);
        worst = std::max(worst, g.dot(a * reading - f + noise() / speed));
      }
      EXPECT_LE(worst, estimate * 1.000001);
      EXPECT_GE(worst, estimate * 0.9);
    }
  }
}

TEST(WorstPerturbation, OfNothingIsNothingAndOfNanIsNan) {
  const double g[] = {1.0, 2.0}, f[] = {0.3, 0.4}, none[] = {0.0, 0.0}, nan[] = {std::nan(""), 0.0};
  double delta[2];
  worst_perturbation<double>({}, 2, g, f, nullptr, delta);
  EXPECT_EQ(delta[0], 0.0);
  worst_perturbation<double>({.velocity_error = 0.1}, 2, none, f, nullptr, delta);
  EXPECT_EQ(delta[1], 0.0);
  worst_perturbation<double>({.velocity_error = 0.1}, 2, nan, f, nullptr, delta);
  EXPECT_TRUE(std::isnan(delta[0]));
}

// The rates of rho_2 beyond its radius and of rho_5 grow by |grad| times the velocity's error; all else
// stays.
TEST(Residuals, AsExecutedAddTheWorstWork) {
  const Networks networks = simple_networks();
  const SafetyProblem problem = simple_problem();
  RandomStream random(3, "residuals as executed");
  const Points x = uniform_points(problem.workspace, 500, random);
  const double error = 0.2, radius = 0.6, band = 0.1;
  const ExecutionDemand demand = {.model = {.velocity_error = error}, .convergence_radius = radius};
  for (const Precision precision : {Precision::double_, Precision::single_}) {
    const Points ideal = residuals(networks, problem, band, x, precision),
                 executed = residuals(networks, problem, band, x, precision, demand);
    const auto column = [](Condition condition) { return static_cast<Eigen::Index>(condition); };
    int near = 0;
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      const Vector at = x.row(i).transpose();
      EXPECT_NEAR(executed(i, column(Condition::lyapunov_decrease)),
                  ideal(i, column(Condition::lyapunov_decrease)) +
                      (at.norm() > radius ? error * 2.1 * at.norm() : 0.0),
                  1e-5);
      const double rate = ideal(i, column(Condition::barrier_decrease));
      const double found = executed(i, column(Condition::barrier_decrease));
      if (std::isinf(rate)) {
        EXPECT_EQ(found, rate);
        continue;
      }
      ++near;
      Points value, d0, d1;
      networks.B.value_and_derivative(x.row(i), Points{{1.0, 0.0}}, value, d0);
      networks.B.value_and_derivative(x.row(i), Points{{0.0, 1.0}}, value, d1);
      EXPECT_NEAR(found, rate + error * std::hypot(d0(0, 0), d1(0, 0)), 1e-5);
    }
    EXPECT_GT(near, 5);
    for (const Condition same : {Condition::lyapunov_positive, Condition::initial, Condition::unsafe})
      EXPECT_EQ(executed.col(column(same)), ideal.col(column(same)));
  }
}

}  // namespace
}  // namespace s2nnds
