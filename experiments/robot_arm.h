// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <deque>
#include <memory>
#include <string>

#include "s2nnds/core/random.h"
#include "s2nnds/deployment/task_space.h"

namespace s2nnds::experiment {

// The arm of robot_arm.xml in MuJoCo, as a controller sees it at 1 kHz: torques in, delayed and noisy joint angles out.
class RobotArm {
 public:
  static constexpr int joints = 7;
  using Joints = std::array<double, joints>;
  using Place = std::array<double, 3>;
  static constexpr double period = 0.001;  // s

  // Of the readings.
  struct Errors {
    int delay = 1;        // periods
    double angle = 2e-5;  // rad, at most, uniform
    double rate = 1e-3;   // rad/s, at most, uniform
  };

  // Throws Error where the file cannot be read.
  RobotArm(const std::string& path, const Errors& errors);

  // At rest with the tip at `position` (m, base frame) and the pen pointing down. False where it does not get there.
  bool place(const Place& position);

  // The delayed reading, and what the controller's own model of the arm (the true one) makes of it.
  ArmState<joints> reading(RandomStream& random);

  // Holds the torques for one period while a force (N, base frame) pushes the tip.
  void hold(const double* torque, const Place& push);

  // What is true now.
  Place position() const;                             // m: of the tip
  Place velocity() const;                             // m/s
  const Joints& posture() const { return posture_; }  // as placed
  static const double* pointing_down();               // the rotation [9] that the pen was placed with

  Joints friction() const;  // N m: dry friction of the joints
  Joints damping() const;   // N m s/rad

 private:
  struct Delete {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_, controller_;  // the arm, and the controller's picture of it
  Errors errors_;
  int tip_ = -1, body_ = -1;
  Joints posture_ = {};
  std::deque<std::pair<Joints, Joints>> past_;  // angles and rates, the newest first
};

}  // namespace s2nnds::experiment
