// SPDX-License-Identifier: BSD-3-Clause
// The passive controller on a simulated point mass.
#include "s2nnds/deployment/passive_controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace s2nnds {
namespace {

// xdot = A x with A = [-1, -2; 2, -1] mm/s around (100, 50) mm: what an exported header calls Motion.
struct Spiral {
  static constexpr int dimension = 2;
  static constexpr double execution_speed = 1.5, disturbance_margin = 4.0;
  static void velocity(const double* x, double* v) noexcept {
    const double a = x[0] - 100.0, b = x[1] - 50.0;
    v[0] = -a - 2.0 * b;
    v[1] = 2.0 * a - b;
  }
  static bool safe(const double* x) noexcept { return std::hypot(x[0] - 100.0, x[1] - 50.0) <= 60.0; }
};
using Controller = PassiveController<Spiral>;

Controller::Settings in_millimetres() {
  Controller::Settings settings;
  settings.metres_per_unit = 0.001;
  return settings;
}

// A mass in the plane, held force, 1 kHz.
struct PointMass {
  double mass = 2.0, x[2] = {140.0, 50.0}, v[2] = {0.0, 0.0};  // kg, mm, mm/s
  double worked = 0.0;                                         // J, by the controller

  void move(const double* force, const double* push) {
    for (int i = 0; i < 2; ++i) {
      const double before = x[i];
      v[i] += 1000.0 * (force[i] + push[i]) / mass * 0.001;
      x[i] += 0.001 * v[i];
      worked += force[i] * (x[i] - before) * 0.001;
    }
  }
  double distance() const { return std::hypot(x[0] - 100.0, x[1] - 50.0); }
};

TEST(PassiveController, FollowsTheMotionToItsGoal) {
  Controller::Settings settings = in_millimetres();
  settings.along = settings.across = 200.0;
  double late[2] = {};
  for (const double mass : {0.0, 2.0}) {  // without and with feed-forward
    settings.mass = mass;
    Controller controller(settings);
    PointMass robot;
    Spiral::velocity(robot.x, robot.v);
    for (double& v : robot.v) v *= Spiral::execution_speed;
    double largest = 0.0;
    const double none[2] = {0.0, 0.0};
    for (int tick = 0; tick < 6000; ++tick) {
      largest = std::max(largest, Controller::monitor(robot.x, robot.v).deviation);
      robot.move(controller.step(robot.x, robot.v).force, none);
    }
    EXPECT_LT(robot.distance(), 0.05);
    late[mass > 0.0] = largest;
  }
  // A lag of mass / damping = 10 ms times |A xdot| = 40 |1.5 A|^2 mm/s^2.
  EXPECT_NEAR(late[0], 0.01 * 40.0 * 1.5 * 1.5 * 5.0, 1.5);
  EXPECT_LT(late[1], 0.15 * late[0]);
}

TEST(PassiveController, DampsAlongAndAcrossTheMotion) {
  Controller::Settings settings = in_millimetres();
  settings.along = 30.0;
  settings.across = 200.0;
  settings.tank_start = 0.0;  // damping alone
  Controller controller(settings);
  const double x[2] = {140.0, 50.0};
  double f[2];
  Spiral::velocity(x, f);
  const double along[2] = {f[0], f[1]}, across[2] = {-f[1], f[0]};
  const Controller::Command first = controller.step(x, along), second = Controller(settings).step(x, across);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(first.force[i], -30.0 * 0.001 * along[i], 1e-9);
    // f . v = 0 costs nothing, so the drive is all there.
    EXPECT_NEAR(second.force[i], 0.001 * (30.0 * 1.5 * f[i] - 200.0 * across[i]), 1e-9);
  }
}

// Someone drags the robot round and round with the motion: an active controller would give energy for ever.
TEST(PassiveController, GivesNoMoreEnergyThanItsTankHeld) {
  Controller::Settings settings = in_millimetres();
  settings.tank_start = 0.02;
  settings.mass = 2.0;
  Controller controller(settings);
  PointMass robot;
  double most = 0.0, least_tank = 1.0;
  for (int tick = 0; tick < 20000; ++tick) {
    const double phase = 0.004 * tick;
    const double push[2] = {6.0 * std::cos(phase), 6.0 * std::sin(1.3 * phase)};
    const Controller::Command command = controller.step(robot.x, robot.v);
    least_tank = std::min(least_tank, command.tank);
    robot.move(command.force, push);
    most = std::max(most, robot.worked);
  }
  EXPECT_LE(most, 0.02 + 1e-4);  // what one period can overdraw
  EXPECT_GE(least_tank, -1e-4);
}

TEST(PassiveController, LimitsItsForceAndStopsAtReadingsThatAreNotFinite) {
  Controller controller(in_millimetres());
  const double far[2] = {1e6, 0.0}, fast[2] = {1e6, 0.0}, bad[2] = {std::nan(""), 0.0}, x[2] = {120.0, 50.0},
               v[2] = {10.0, 0.0};
  EXPECT_LE(std::hypot(controller.step(far, fast).force[0], controller.step(far, fast).force[1]),
            50.0 + 1e-9);
  EXPECT_FALSE(controller.step(x, v).stopped);
  EXPECT_TRUE(controller.step(bad, v).stopped);
  const Controller::Command after = controller.step(x, v);
  EXPECT_TRUE(after.stopped);
  EXPECT_NEAR(after.force[0], -1.0, 1e-9);
  EXPECT_EQ(controller.step(x, bad).force[0], 0.0);
  controller.reset();
  EXPECT_FALSE(controller.step(x, v).stopped);
  Controller::Settings wrong = in_millimetres();
  wrong.period = 0.0;
  EXPECT_FALSE(Controller(wrong).valid());
  EXPECT_TRUE(Controller(wrong).step(x, v).stopped);
}

TEST(PassiveController, MonitorSaysWhatTheCertificateCovers) {
  const double x[2] = {140.0, 50.0}, outside[2] = {170.0, 50.0}, bad[2] = {std::nan(""), 0.0};
  double v[2];
  Spiral::velocity(x, v);
  for (double& value : v) value *= Spiral::execution_speed;
  EXPECT_TRUE(Controller::monitor(x, v).covered);
  v[0] += 5.9;  // the margin of 4 at 1.5 times the speed
  EXPECT_TRUE(Controller::monitor(x, v).covered);
  v[0] += 0.2;
  EXPECT_FALSE(Controller::monitor(x, v).covered);
  EXPECT_NEAR(Controller::monitor(x, v).deviation, 6.1, 1e-9);
  EXPECT_FALSE(Controller::monitor(outside, v).covered);
  EXPECT_FALSE(Controller::monitor(bad, v).covered);
  EXPECT_FALSE(Controller::monitor(x, bad).covered);
}

}  // namespace
}  // namespace s2nnds
