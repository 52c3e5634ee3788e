// SPDX-License-Identifier: BSD-3-Clause
// The task-space controller on made-up arms, against Eigen.
#include "s2nnds/deployment/task_space.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

constexpr int kJoints = 7;
using Controller = TaskSpaceController<kJoints>;
using Jacobian = Eigen::Matrix<double, 6, kJoints, Eigen::RowMajor>;
using Mass = Eigen::Matrix<double, kJoints, kJoints, Eigen::RowMajor>;
using Joints = Eigen::Matrix<double, kJoints, 1>;
using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Arm {
  explicit Arm(std::uint64_t seed) : random(seed, "arm") {
    const auto draw = [&] { return random.normal(); };
    jacobian = Jacobian::NullaryExpr(draw);
    const Mass root = Mass::NullaryExpr(draw);
    mass = root * root.transpose() + Mass::Identity();
    rate = Joints::NullaryExpr(draw);
    q = Joints::NullaryExpr(draw);
    std::copy_n(jacobian.data(), jacobian.size(), &state.jacobian[0][0]);
    std::copy_n(mass.data(), mass.size(), &state.mass[0][0]);
    std::copy_n(rate.data(), kJoints, state.rate);
    std::copy_n(q.data(), kJoints, state.q);
  }

  RandomStream random;
  Jacobian jacobian;
  Mass mass;
  Joints rate, q;
  ArmState<kJoints> state;
};

// Nothing but the force, and limits that are not met.
Controller::Settings bare() {
  Controller::Settings settings;
  settings.height_stiffness = settings.height_damping = settings.rotation_stiffness = 0.0;
  settings.rotation_damping = settings.posture_stiffness = settings.posture_damping = 0.0;
  settings.most_torque_rate = 1e9;
  for (double& most : settings.most_torque) most = 1e6;
  return settings;
}

Joints torques(const Controller::Settings& settings, const Arm& arm, const Eigen::Vector3d& force,
               const Controller::Goal& goal = {}) {
  const Controller::Command command = Controller(settings).step(arm.state, force.data(), goal);
  EXPECT_FALSE(command.stopped);
  EXPECT_FALSE(command.limited);
  return Eigen::Map<const Joints>(command.torque);
}

TEST(TaskSpace, SolvesPositiveSystemsAndRefusesOthers) {
  double a[2][2] = {{4.0, 0.0}, {2.0, 3.0}}, b[2] = {8.0, 8.0};
  EXPECT_TRUE(solve_positive(a, b));
  EXPECT_NEAR(b[0], 1.0, 1e-14);
  EXPECT_NEAR(b[1], 2.0, 1e-14);
  double indefinite[2][2] = {{1.0, 0.0}, {2.0, 1.0}}, c[2] = {1.0, 1.0};
  EXPECT_FALSE(solve_positive(indefinite, c));
  double bad[1][1] = {{std::nan("")}}, d[1] = {1.0};
  EXPECT_FALSE(solve_positive(bad, d));
}

TEST(TaskSpace, FindsTheRotationBetween) {
  RandomStream random(3, "rotations");
  for (int k = 0; k < 1000; ++k) {
    const auto draw = [&] { return random.normal(); };
    const Eigen::Vector3d axis = Eigen::Vector3d::NullaryExpr(draw).normalized();
    const double angle =
        k % 4 == 0 ? std::pow(10.0, random.uniform(-9.0, 0.0)) : random.uniform(0.0, 3.14159);
    const Rotation from =
        Eigen::Quaterniond(Eigen::Vector4d::NullaryExpr(draw).normalized()).toRotationMatrix();
    const Rotation to = Eigen::AngleAxisd(angle, axis).toRotationMatrix() * from;
    Eigen::Vector3d found;
    rotation_between(from.data(), to.data(), found.data());
    EXPECT_LT((found - angle * axis).norm(), 1e-9 + 1e-6 * (angle > 3.0)) << angle;
  }
  const Rotation one = Rotation::Identity(), half = Eigen::Vector3d(-1.0, 1.0, -1.0).asDiagonal();
  Eigen::Vector3d found;
  rotation_between(one.data(), one.data(), found.data());
  EXPECT_EQ(found.norm(), 0.0);
  rotation_between(one.data(), half.data(), found.data());
  EXPECT_NEAR((found.cwiseAbs() - Eigen::Vector3d(0.0, 3.14159265358979, 0.0)).norm(), 0.0, 1e-12);
}

// The power at the joints is that at the tool.
TEST(TaskSpace, PutsTheForceThroughTheJacobian) {
  const Arm arm(1);
  const Eigen::Vector3d force(3.0, -5.0, 7.0);
  Controller::Goal goal;
  goal.hold_height = false;
  const Joints torque = torques(bare(), arm, force, goal);
  EXPECT_NEAR(torque.dot(arm.rate), force.dot((arm.jacobian * arm.rate).head(3)), 1e-10);
  EXPECT_LT((torque - arm.jacobian.topRows(3).transpose() * force).norm(), 1e-12);
}

TEST(TaskSpace, HoldsHeightAndOrientationLikeSpringsAndDampers) {
  Arm arm(2);
  Controller::Settings settings = bare();
  settings.height_stiffness = 1000.0;
  settings.height_damping = 50.0;
  settings.rotation_stiffness = 30.0;
  settings.rotation_damping = 4.0;
  arm.state.position[2] = 0.35;
  Controller::Goal goal;
  goal.height = 0.3;
  const Eigen::Vector3d turn(0.1, -0.2, 0.3);
  const Rotation wanted = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  std::copy_n(wanted.data(), 9, goal.rotation);
  const Eigen::Matrix<double, 6, 1> velocity = arm.jacobian * arm.rate;
  Eigen::Matrix<double, 6, 1> wrench;
  wrench << 1.0, 2.0, 1000.0 * (0.3 - 0.35) - 50.0 * velocity[2], 30.0 * turn - 4.0 * velocity.tail(3);
  const Joints found = torques(settings, arm, {1.0, 2.0, 99.0}, goal);
  EXPECT_LT((found - arm.jacobian.transpose() * wrench).norm(), 1e-9);
}

// The posture moves the joints and not the tool: J M^-1 torque = 0.
TEST(TaskSpace, TheToolDoesNotFeelThePosture) {
  Arm arm(4);
  Controller::Settings settings = bare();
  settings.posture_stiffness = 10.0;
  settings.posture_damping = 2.0;
  Controller::Goal goal;
  goal.hold_height = false;
  const Joints torque = torques(settings, arm, Eigen::Vector3d::Zero(), goal);
  const Joints acceleration = arm.mass.llt().solve(torque);
  EXPECT_GT(acceleration.norm(), 0.1);
  EXPECT_LT((arm.jacobian * acceleration).norm(), 1e-6 * acceleration.norm());
  // A singular arm goes without.
  arm.state.mass[0][0] = -1.0;
  EXPECT_EQ(torques(settings, arm, Eigen::Vector3d::Zero(), goal).norm(), 0.0);
}

TEST(TaskSpace, MakesUpForFrictionAndBias) {
  Arm arm(5);
  Controller::Settings settings = bare();
  for (int j = 0; j < kJoints; ++j) {
    arm.state.rate[j] = 0.1 * (j - 3);
    arm.state.bias[j] = j;
    settings.coulomb[j] = 2.0;
    settings.viscous[j] = 0.5;
  }
  Controller::Goal goal;
  goal.hold_height = false;
  const Joints torque = torques(settings, arm, Eigen::Vector3d::Zero(), goal);
  for (int j = 0; j < kJoints; ++j) {
    const double sign = j > 3 ? 1.0 : j < 3 ? -1.0 : 0.0;
    EXPECT_NEAR(torque[j], j + 2.0 * sign + 0.05 * (j - 3), 1e-7);
  }
}

TEST(TaskSpace, FindsTheEffectiveMass) {
  Arm arm(6);
  const Eigen::Vector3d direction = Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
  const Joints along = arm.jacobian.topRows(3).transpose() * direction;
  EXPECT_NEAR(effective_mass(arm.state, direction.data()), 1.0 / along.dot(arm.mass.llt().solve(along)),
              1e-9);
}

TEST(TaskSpace, LimitsTorquesAndTheirRate) {
  Arm arm(7);
  Controller::Settings settings = bare();
  settings.most_torque_rate = 1000.0;
  for (int j = 0; j < kJoints; ++j) settings.most_torque[j] = 10.0;
  Controller controller(settings);
  double last[kJoints];
  for (int j = 0; j < kJoints; ++j) last[j] = j - 3.0;
  controller.reset(last);
  Controller::Goal goal;
  goal.hold_height = false;
  const double force[3] = {500.0, -300.0, 200.0};
  const auto follow = [&](double* towards, bool stopped) {
    const Controller::Command command = controller.step(arm.state, force, goal);
    EXPECT_EQ(command.stopped, stopped);
    for (int j = 0; j < kJoints; ++j) {
      EXPECT_LE(std::abs(command.torque[j] - last[j]), 1.0 + 1e-12);  // 1000 N m/s for 1 ms
      EXPECT_LE(std::abs(command.torque[j]), 10.0);
      last[j] = command.torque[j];
      if (towards != nullptr) towards[j] = command.torque[j];
    }
    return command.limited;
  };
  for (int tick = 0; tick < 20; ++tick) EXPECT_TRUE(follow(nullptr, false));
  const Joints wanted = arm.jacobian.topRows(3).transpose() * Eigen::Map<const Eigen::Vector3d>(force);
  for (int j = 0; j < kJoints; ++j) EXPECT_NEAR(last[j], std::clamp(wanted[j], -10.0, 10.0), 1e-9);
  // A reading that makes no sense: to nothing, no faster than that.
  arm.state.rate[2] = std::numeric_limits<double>::quiet_NaN();
  for (int tick = 0; tick < 12; ++tick) follow(nullptr, true);
  for (const double torque : last) EXPECT_EQ(torque, 0.0);
  settings.period = 0.0;
  EXPECT_FALSE(Controller(settings).valid());
  EXPECT_TRUE(Controller(settings).step(arm.state, force, goal).stopped);
}

}  // namespace
}  // namespace s2nnds
