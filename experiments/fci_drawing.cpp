// SPDX-License-Identifier: BSD-3-Clause
// The paper's robot experiment with Franka's own interface (libfranka, FCI): the arm draws one certified motion with passive
// interaction control, torques at 1 kHz. Where the tool is becomes the start of the first demonstration, and the motion lies
// in the plane X-Y of the arm's base (in three dimensions: X-Y-Z), with impedance in Z and orientation. The robot makes up for
// gravity itself.
//
// It prints the row of robot_drawing's table, and writes OUT/robot_drawing.json, of which `plot_drawing` makes a figure.
// Keep the stop button at hand: the obstacle of the certificate is where the drawing puts it, not where you see one.
//
// Usage: fci_drawing RUN.h5 HOST [--out FOLDER] [--size METRES] [--ready] [--soft-real-time] [--coulomb N_M x 7]
#include <fmt/format.h>
#include <franka/exception.h>
#include <franka/model.h>
#include <franka/robot.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <numbers>

#include "drawing.h"
#include "run_table.h"
#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/json_text.h"
#include "s2nnds/core/python_module.h"

namespace s2nnds::experiment {
namespace {

using nlohmann::json;

struct Arguments {
  std::string run, host, out = "runs/fci_drawing";
  double size = 0.0;  // m; 0: Paper's
  bool ready = false, soft_real_time = false, draw = true;
  std::vector<double> coulomb = std::vector<double>(kArmJoints, 0.0);  // N m
};

// The tool points down before the arm.
constexpr std::array<double, kArmJoints> kReady = {0.0,
                                                   -std::numbers::pi / 4,
                                                   0.0,
                                                   -3 * std::numbers::pi / 4,
                                                   0.0,
                                                   std::numbers::pi / 2,
                                                   std::numbers::pi / 4};

ArmState<kArmJoints> reading(const franka::RobotState& state, const franka::Model& model) {
  ArmState<kArmJoints> arm;
  const auto jacobian =
      model.zeroJacobian(franka::Frame::kEndEffector, state);  // by columns, as all that follow
  const auto mass = model.mass(state);
  const auto bias = model.coriolis(state);
  for (std::size_t j = 0; j < kArmJoints; ++j) {
    arm.q[j] = state.q[j];
    arm.rate[j] = state.dq[j];
    arm.bias[j] = bias[j];
    for (std::size_t i = 0; i < 6; ++i) arm.jacobian[i][j] = jacobian[6 * j + i];
    for (std::size_t i = 0; i < kArmJoints; ++i) arm.mass[i][j] = mass[kArmJoints * j + i];
  }
  for (std::size_t i = 0; i < 3; ++i) {
    arm.position[i] = state.O_T_EE[12 + i];
    for (std::size_t j = 0; j < 3; ++j) arm.rotation[3 * i + j] = state.O_T_EE[4 * j + i];
  }
  return arm;
}

// To kReady within the joints' limits on velocity and acceleration, by a polynomial of fifth degree in time.
void move_to_ready(franka::Robot& robot) {
  const auto start = robot.readOnce().q_d;
  double farthest = 0.0, time = 0.0;
  for (std::size_t j = 0; j < kArmJoints; ++j) farthest = std::max(farthest, std::abs(kReady[j] - start[j]));
  const double seconds = std::max(1.0, 4.0 * farthest);
  robot.control([&](const franka::RobotState&, franka::Duration period) {
    time += period.toSec();
    const double s = std::min(1.0, time / seconds), share = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    std::array<double, kArmJoints> q;
    for (std::size_t j = 0; j < kArmJoints; ++j) q[j] = start[j] + share * (kReady[j] - start[j]);
    franka::JointPositions command(q);
    return s < 1.0 ? command : franka::MotionFinished(command);
  });
}

// What the control loop notes: it is looked at when the arm has come to rest.
struct Tick {
  Place place, velocity;
  double seconds, microseconds, tank;
};

template <int n>
class Drawing {
 public:
  using Motion = LoadedMotion<n>;
  using Passive = PassiveController<Motion>;

  Drawing(franka::Robot& robot, const Policy& policy, const std::array<double, n>& start,
          const Arguments& arguments)
      : robot_(robot),
        model_(robot.loadModel()),
        paper_(policy.info, arguments.size > 0.0 ? arguments.size
                                                 : Paper<n>(policy.info).metres * policy.info.position_scale),
        arguments_(arguments),
        first_(robot.readOnce()) {
    paper_.goal = {first_.O_T_EE[12], first_.O_T_EE[13], first_.O_T_EE[14]};
    const Place at = paper_.on_robot(start.data());
    for (std::size_t i = 0; i < 3; ++i) paper_.goal[i] -= at[i] - paper_.goal[i];
    ideal_ = ideal_motion<n>(start, policy.info);
    check_reach();
  }

  Drawn draw() {
    follow();
    Drawn drawn;
    drawn.stop = stop_ == SafeStop::none ? "" : in_words(stop_);
    for (std::size_t k = 0; k < ticks_.size(); ++k) {
      const Tick& tick = ticks_[k];
      note<n>(drawn, tick.seconds, static_cast<long>(k), paper_, ideal_, tick.place, tick.velocity);
      drawn.microseconds.push_back(tick.microseconds);
      drawn.energy = std::max(drawn.energy, typename Passive::Settings().tank_start - tick.tank);
    }
    drawn.mean_path /= static_cast<double>(std::max(1L, drawn.measured));
    return drawn;
  }

 private:
  // From the shoulder to each place of the motion: what the arm reaches with some ease.
  void check_reach() const {
    for (const auto& x : ideal_) {
      const Place place = paper_.on_robot(x.data());
      const double around = std::hypot(place[0], place[1]), reach = std::hypot(around, place[2] - 0.333);
      check(around >= 0.2 && reach <= 0.75,
            "fci_drawing: the motion passes ({:.2f}, {:.2f}, {:.2f}) m in the base's frame, which this arm "
            "does not reach "
            "well; expected another place of the tool at its start, or a smaller --size",
            place[0], place[1], place[2]);
    }
  }

  typename Passive::Settings passive_settings(const ArmState<kArmJoints>& arm) const {
    typename Passive::Settings settings;
    settings.metres_per_unit = paper_.metres;
    settings.along = settings.across = 200.0;
    settings.mass = mean_effective_mass<n>(arm);
    settings.longest_period = 0.02;  // s: the interface itself stops after 20 lost packets in a row
    return settings;
  }

  TaskSpaceController<kArmJoints>::Settings task_settings() const {
    TaskSpaceController<kArmJoints>::Settings settings;
    for (std::size_t j = 0; j < kArmJoints; ++j) {
      settings.coulomb[j] = arguments_.coulomb[j];
      settings.most_torque[j] = j < 4 ? 87.0 : 12.0;
    }
    settings.friction_width = 0.003;
    settings.most_torque_rate = 900.0;  // the interface allows 1000
    return settings;
  }

  void follow() {
    const ArmState<kArmJoints> still = reading(first_, model_);
    Passive passive(passive_settings(still));
    TaskSpaceController<kArmJoints> task(task_settings());
    check(passive.valid() && task.valid(), "fci_drawing: settings out of range");
    TaskSpaceController<kArmJoints>::Goal goal;
    goal.hold_height = n == 2;
    goal.height = still.position[2];
    std::copy_n(still.rotation, 9, goal.rotation);
    std::copy_n(still.q, kArmJoints, goal.posture);
    task.reset(first_.tau_J_d.data());

    const double longest = 1.5 * 0.005 * static_cast<double>(ideal_.size()) + 3.0;
    double seconds = 0.0, stopped_at = -1.0;
    ticks_.reserve(static_cast<std::size_t>(1100.0 * longest));  // nothing is allocated in the loop
    robot_.control(
        [&](const franka::RobotState& state, franka::Duration period) {
          const double begin = processor_microseconds();
          seconds += period.toSec();
          const ArmState<kArmJoints> arm = reading(state, model_);
          const Place place = {arm.position[0], arm.position[1], arm.position[2]},
                      velocity = tool_velocity(arm);
          const auto x = paper_.on_paper(place);
          const auto v = paper_.rate_on_paper(velocity);
          const auto command = passive.step(x.data(), v.data(), period.toSec(), 0.0);
          stop_ = command.stop;
          double force[3] = {};
          std::copy_n(command.force, n, force);
          const auto torque = task.step(arm, force, goal);
          if (ticks_.size() < ticks_.capacity())
            ticks_.push_back({place, velocity, seconds, processor_microseconds() - begin, command.tank});
          // After a safe stop there is a second of damping.
          if (stop_ != SafeStop::none && stopped_at < 0.0) stopped_at = seconds;
          const bool arrived = normalised_goal_distance<n>(x, *paper_.info) < kArrived;
          const bool over = arrived || seconds > longest || (stopped_at >= 0.0 && seconds > stopped_at + 1.0);
          std::array<double, kArmJoints> torques;
          std::copy_n(torque.torque, kArmJoints, torques.begin());
          franka::Torques told(torques);
          return over ? franka::MotionFinished(told) : told;
        },
        true);  // limits on rates are kept by the interface too
  }

  franka::Robot& robot_;
  franka::Model model_;
  Paper<n> paper_;
  const Arguments& arguments_;
  franka::RobotState first_;
  Vectors<n> ideal_;
  std::vector<Tick> ticks_;
  SafeStop stop_ = SafeStop::none;
};

// The first demonstration's start, moved as it was for training.
template <int n>
std::array<double, n> first_start(const RunRecord& run) {
  std::array<double, n> x;
  for (int i = 0; i < n; ++i) {
    x[static_cast<std::size_t>(i)] =
        run.data.demonstrations[0].position(0, i) + run.data.frame.goal[i] - run.data.frame.goals(0, i);
  }
  return x;
}

template <int n>
int draw_run(const RunRecord& run, const Policy& policy, franka::Robot& robot, const Arguments& arguments) {
  LoadedMotion<n>::load(policy);
  Drawing<n> drawing(robot, policy, first_start<n>(run), arguments);
  const Drawn drawn = drawing.draw();
  const double certified =
      policy.info.execution_speed * policy.info.disturbance_margin / policy.info.velocity_scale;
  Table table{.head = table_head(),
              .rows = {row_of(run.name, "feed-forward", "demonstrated", {drawn}, certified)}};
  json found = {{"tables", {{"drawn", table.json()}}}};
  found["motions"] = json::array({{{"run", run.name},
                                   {"file", std::filesystem::absolute(arguments.run).string()},
                                   {"motions", json::array({{{"control", "feed-forward"},
                                                             {"scene", "demonstrated"},
                                                             {"left", drawn.left},
                                                             {"arrived", drawn.arrived},
                                                             {"path", drawn.path}}})}}});
  std::filesystem::create_directories(arguments.out);
  const std::string results = (std::filesystem::path(arguments.out) / "robot_drawing.json").string();
  write_atomic_file(results, json_text(found), "what was drawn");
  fmt::print("{}", table.text());
  if (!drawn.stop.empty()) fmt::print(stderr, "fci_drawing: {}\n", drawn.stop);
  if (arguments.draw) run_python_module("fci_drawing", "plot_drawing", {results});
  return drawn.arrived && drawn.stop.empty() ? 0 : 3;
}

int run_fci_drawing(const Arguments& arguments) {
  const RunRecord run = load_run(arguments.run);
  const Policy policy = policy_of(run);
  check(policy.info.guarantee == "invariant", "{}: found the guarantee {}, expected invariant", arguments.run,
        policy.info.guarantee);
  check(policy.info.dimension == 2 || policy.info.dimension == 3,
        "{}: found a motion in {} dimensions, expected 2 or 3", arguments.run, policy.info.dimension);
  franka::Robot robot(arguments.host, arguments.soft_real_time ? franka::RealtimeConfig::kIgnore
                                                               : franka::RealtimeConfig::kEnforce);
  constexpr std::array<double, 7> torque = {40.0, 40.0, 40.0, 40.0, 40.0, 40.0, 40.0};
  constexpr std::array<double, 6> force = {60.0, 60.0, 60.0, 60.0, 60.0, 60.0};
  robot.setCollisionBehavior(torque, torque, force, force);
  if (arguments.ready) move_to_ready(robot);
  return policy.info.dimension == 2 ? draw_run<2>(run, policy, robot, arguments)
                                    : draw_run<3>(run, policy, robot, arguments);
}

}  // namespace
}  // namespace s2nnds::experiment

int main(int argc, char** argv) {
  s2nnds::experiment::Arguments arguments;
  CLI::App app("Draws a certified motion with Franka's arm.", "fci_drawing");
  app.add_option("run", arguments.run, "run file, invariant, in two or three dimensions")->required();
  app.add_option("host", arguments.host, "the robot's address")->required();
  app.add_option("--out", arguments.out, "folder of results and figure")->capture_default_str();
  app.add_option("--size", arguments.size,
                 "m that the largest coordinate becomes (0.15; in three dimensions 0.12)")
      ->check(CLI::Range(0.01, 0.5));
  app.add_flag("--ready", arguments.ready, "go to the ready posture first");
  app.add_flag("--soft-real-time", arguments.soft_real_time, "ask for no real-time kernel (simulated arms)");
  app.add_option("--coulomb", arguments.coulomb, "N m of dry friction to make up for, of the 7 joints")
      ->expected(7);
  app.add_flag("!--no-figures", arguments.draw, "draw nothing");
  CLI11_PARSE(app, argc, argv);
  try {
    return s2nnds::experiment::run_fci_drawing(arguments);
  } catch (const std::exception& error) {
    fmt::print(stderr, "fci_drawing: {}\n", error.what());
    return 2;
  }
}
