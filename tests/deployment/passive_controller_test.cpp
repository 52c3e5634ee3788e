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
  static bool in_workspace(const double* x) noexcept {
    return std::abs(x[0] - 100.0) <= 90.0 && std::abs(x[1] - 50.0) <= 90.0;
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

// The matrix that the empty tank leaves, column by column, has `along` and `across` as its eigenvalues.
TEST(PassiveController, DampsAlongAndAcrossTheMotion) {
  Controller::Settings settings = in_millimetres();
  settings.along = 30.0;
  settings.across = 200.0;
  settings.tank_start = 0.0;  // damping alone
  Controller controller(settings);
  const double x[2] = {140.0, 65.0};
  double f[2], d[2][2];
  Spiral::velocity(x, f);
  for (int j = 0; j < 2; ++j) {
    const double v[2] = {j == 0 ? 100.0 : 0.0, j == 1 ? 100.0 : 0.0};
    const Controller::Command command = controller.step(x, v);
    EXPECT_EQ(command.drive, 0.0);
    for (int i = 0; i < 2; ++i) d[i][j] = -command.force[i] / 0.1;
  }
  EXPECT_NEAR(d[0][1], d[1][0], 1e-9);
  for (int i = 0; i < 2; ++i) {
    const double across = i == 0 ? -f[1] : f[0];
    EXPECT_NEAR(d[i][0] * f[0] + d[i][1] * f[1], 30.0 * f[i], 1e-9 * 200.0 * std::hypot(f[0], f[1]));
    EXPECT_NEAR(-d[i][0] * f[1] + d[i][1] * f[0], 200.0 * across, 1e-9 * 200.0 * std::hypot(f[0], f[1]));
  }
}

// Someone drags the robot round and round with the motion: an active controller would give energy for ever.
TEST(PassiveController, GivesNoMoreEnergyThanItsTankHeld) {
  Controller::Settings settings = in_millimetres();
  settings.tank_start = 0.2;
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
  EXPECT_LE(most, 0.2);
  EXPECT_GE(least_tank, 0.0);
}

// Someone carries it along the motion at half its speed, where f gives the most.
TEST(PassiveController, IsDrainedButNeverBelowNothing) {
  Controller::Settings settings = in_millimetres();
  settings.tank_start = 0.2;
  Controller controller(settings);
  double x[2], v[2], worked = 0.0, least_tank = 1.0, first_drive = 0.0, last_drive = 1.0;
  const double turn = 0.5 * Spiral::execution_speed * 2.0 * 0.001;  // rad a tick
  for (int tick = 0; tick < 20000; ++tick) {
    const double phase = turn * tick, rate = 1000.0 * turn;
    for (int i = 0; i < 2; ++i) {
      x[i] = (i == 0 ? 100.0 : 50.0) + 40.0 * (i == 0 ? std::cos(phase) : std::sin(phase));
      v[i] = 40.0 * rate * (i == 0 ? -std::sin(phase) : std::cos(phase));
    }
    const Controller::Command command = controller.step(x, v);
    worked += 0.000001 * (command.force[0] * v[0] + command.force[1] * v[1]);
    least_tank = std::min(least_tank, command.tank);
    if (tick == 0) first_drive = command.drive;
    last_drive = command.drive;
  }
  EXPECT_EQ(first_drive, 1.0);
  EXPECT_LT(last_drive, 0.6);
  EXPECT_GT(worked, 0.05);
  EXPECT_LE(worked, 0.2 + 0.001);
  EXPECT_GE(least_tank, 0.0);
  EXPECT_LT(least_tank, 0.15);
}

TEST(PassiveController, LimitsItsForce) {
  Controller::Settings settings = in_millimetres();
  settings.along = settings.across = 1000.0;
  const double x[2] = {20.0, 0.0}, v[2] = {0.0, 1400.0};
  const Controller::Command command = Controller(settings).step(x, v);
  EXPECT_NEAR(std::hypot(command.force[0], command.force[1]), 50.0, 1e-9);
  EXPECT_EQ(command.stop, SafeStop::none);
}

TEST(PassiveController, StopsWhereItIsToldWhatCannotBeCovered) {
  const double nan = std::nan(""), x[2] = {120.0, 50.0}, v[2] = {10.0, 0.0}, bad[2] = {nan, 0.0},
               outside[2] = {200.0, 50.0}, fast[2] = {0.0, 1600.0};
  const auto after_start = [&](const double* place, const double* velocity, double elapsed, double age) {
    Controller controller(in_millimetres());
    EXPECT_EQ(controller.step(x, v).stop, SafeStop::none);
    const SafeStop stop = controller.step(place, velocity, elapsed, age).stop;
    if (stop != SafeStop::none) {  // it stays so, with damping alone, until it is reset
      const Controller::Command next = controller.step(x, v);
      EXPECT_EQ(next.stop, stop);
      EXPECT_NEAR(next.force[0], -1.0, 1e-9);
      EXPECT_EQ(controller.step(x, bad).force[0], 0.0);
      controller.reset();
      EXPECT_EQ(controller.step(x, v).stop, SafeStop::none);
    }
    return stop;
  };
  EXPECT_EQ(after_start(x, v, 0.0039, 0.0039), SafeStop::none);
  EXPECT_EQ(after_start(bad, v, 0.001, 0.0), SafeStop::reading);
  EXPECT_EQ(after_start(x, bad, 0.001, 0.0), SafeStop::reading);
  EXPECT_EQ(after_start(outside, v, 0.001, 0.0), SafeStop::workspace);
  EXPECT_EQ(after_start(x, v, 0.004, 0.0), SafeStop::late);
  EXPECT_EQ(after_start(x, v, nan, 0.0), SafeStop::late);
  EXPECT_EQ(after_start(x, v, 0.001, 0.004), SafeStop::old);
  EXPECT_EQ(after_start(x, v, 0.001, nan), SafeStop::old);
  EXPECT_EQ(after_start(x, fast, 0.001, 0.0), SafeStop::fast);
  EXPECT_STREQ(in_words(SafeStop::late), "stopped: found a call later than the longest period");

  const auto refused = [&](double Controller::Settings::*setting, double value) {
    Controller::Settings wrong = in_millimetres();
    wrong.*setting = value;
    Controller controller(wrong);
    EXPECT_EQ(controller.step(x, v).stop, SafeStop::settings);
    controller.reset();
    return !controller.valid() && controller.step(x, v).force[0] == 0.0;
  };
  using Settings = Controller::Settings;
  EXPECT_TRUE(refused(&Settings::period, 0.0));
  EXPECT_TRUE(refused(&Settings::longest_period, 0.001));
  EXPECT_TRUE(refused(&Settings::longest_delay, nan));
  EXPECT_TRUE(refused(&Settings::along, -1.0));
  EXPECT_TRUE(refused(&Settings::fastest, 0.0));
  EXPECT_TRUE(refused(&Settings::tank_start, 11.0));
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
