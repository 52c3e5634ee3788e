// SPDX-License-Identifier: BSD-3-Clause
#include "robot_arm.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "s2nnds/core/check.h"

namespace s2nnds::experiment {
namespace {

constexpr int kJoints = RobotArm::joints;
constexpr double kDown[9] = {1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0};
// In the middle of the joints' ranges, the tool pointing down.
constexpr double kReady[kJoints] = {0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398};

}  // namespace

RobotArm::RobotArm(const std::string& path, const Errors& errors) : errors_(errors) {
  char reason[500] = "";
  model_.reset(mj_loadXML(path.c_str(), nullptr, reason, sizeof reason));
  check(model_ != nullptr, "{}: found no model that MuJoCo reads: {}", path, reason);
  check(model_->nv == kJoints, "{}: found {} joints, expected {}", path, model_->nv, kJoints);
  data_.reset(mj_makeData(model_.get()));
  controller_.reset(mj_makeData(model_.get()));
  tip_ = mj_name2id(model_.get(), mjOBJ_SITE, "tip");
  check(tip_ >= 0, "{}: found no site tip", path);
  body_ = model_->site_bodyid[tip_];
}

bool RobotArm::place(const Place& position) {
  mj_resetData(model_.get(), data_.get());
  std::copy_n(kReady, kJoints, data_->qpos);
  double error = 0.0;
  for (int step = 0; step < 300; ++step) {  // damped least squares
    mj_kinematics(model_.get(), data_.get());
    mj_comPos(model_.get(), data_.get());
    double jacobian[6 * kJoints], twist[6], square[6][6];
    mj_jacSite(model_.get(), data_.get(), jacobian, jacobian + 3 * kJoints, tip_);
    for (int i = 0; i < 3; ++i)
      twist[i] = position[static_cast<std::size_t>(i)] - data_->site_xpos[3 * tip_ + i];
    rotation_between(data_->site_xmat + 9 * tip_, kDown, twist + 3);
    error = std::sqrt(std::inner_product(twist, twist + 6, twist, 0.0));
    if (error < 1e-10) break;
    for (int i = 0; i < 6; ++i) {
      for (int k = 0; k < 6; ++k) {
        square[i][k] = i == k ? 1e-6 : 0.0;
        for (int j = 0; j < kJoints; ++j)
          square[i][k] += jacobian[i * kJoints + j] * jacobian[k * kJoints + j];
      }
    }
    if (!solve_positive(square, twist)) return false;
    for (int j = 0; j < kJoints; ++j) {
      double change = 0.0;
      for (int i = 0; i < 6; ++i) change += jacobian[i * kJoints + j] * twist[i];
      data_->qpos[j] = std::clamp(data_->qpos[j] + std::clamp(change, -0.2, 0.2),
                                  model_->jnt_range[2 * j] + 0.02, model_->jnt_range[2 * j + 1] - 0.02);
    }
  }
  std::copy_n(data_->qpos, kJoints, posture_.begin());
  mj_forward(model_.get(), data_.get());
  past_.assign(static_cast<std::size_t>(errors_.delay) + 1, {posture_, Joints{}});
  return error < 1e-8;
}

ArmState<RobotArm::joints> RobotArm::reading(RandomStream& random) {
  const auto& [angles, rates] = past_.back();
  for (std::size_t j = 0; j < kJoints; ++j) {
    controller_->qpos[j] = angles[j] + errors_.angle * random.uniform(-1.0, 1.0);
    controller_->qvel[j] = rates[j] + errors_.rate * random.uniform(-1.0, 1.0);
  }
  mj_fwdPosition(model_.get(), controller_.get());
  mj_fwdVelocity(model_.get(), controller_.get());
  ArmState<joints> state;
  std::copy_n(controller_->qpos, kJoints, state.q);
  std::copy_n(controller_->qvel, kJoints, state.rate);
  std::copy_n(controller_->site_xpos + 3 * tip_, 3, state.position);
  std::copy_n(controller_->site_xmat + 9 * tip_, 9, state.rotation);
  mj_jacSite(model_.get(), controller_.get(), state.jacobian[0], state.jacobian[3], tip_);
  mj_fullM(model_.get(), &state.mass[0][0], controller_->qM);
  std::copy_n(controller_->qfrc_bias, kJoints, state.bias);
  return state;
}

void RobotArm::hold(const double* torque, const Place& push) {
  const double none[3] = {};
  const int substeps = static_cast<int>(std::lround(period / model_->opt.timestep));
  for (int k = 0; k < substeps; ++k) {
    std::copy_n(torque, kJoints, data_->qfrc_applied);
    mj_applyFT(model_.get(), data_.get(), push.data(), none, data_->site_xpos + 3 * tip_, body_,
               data_->qfrc_applied);
    mj_step(model_.get(), data_.get());
    mj_kinematics(model_.get(), data_.get());  // of where it is now: the tip, and its Jacobian
    mj_comPos(model_.get(), data_.get());
  }
  past_.emplace_front();
  std::copy_n(data_->qpos, kJoints, past_.front().first.begin());
  std::copy_n(data_->qvel, kJoints, past_.front().second.begin());
  past_.pop_back();
}

RobotArm::Place RobotArm::position() const {
  return {data_->site_xpos[3 * tip_], data_->site_xpos[3 * tip_ + 1], data_->site_xpos[3 * tip_ + 2]};
}

RobotArm::Place RobotArm::velocity() const {
  double jacobian[3 * kJoints];
  mj_jacSite(model_.get(), data_.get(), jacobian, nullptr, tip_);
  Place v = {};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < kJoints; ++j) v[i] += jacobian[i * kJoints + j] * data_->qvel[j];
  }
  return v;
}

const double* RobotArm::pointing_down() { return kDown; }

RobotArm::Joints RobotArm::friction() const {
  Joints found;
  std::copy_n(model_->dof_frictionloss, kJoints, found.begin());
  return found;
}

RobotArm::Joints RobotArm::damping() const {
  Joints found;
  std::copy_n(model_->dof_damping, kJoints, found.begin());
  return found;
}

}  // namespace s2nnds::experiment
