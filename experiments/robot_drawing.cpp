// SPDX-License-Identifier: BSD-3-Clause
// The paper's robot experiment, in simulation: a 7-joint arm with a pen (robot_arm.xml, MuJoCo) draws certified motions at
// 1 kHz with passive interaction control. A motion in two dimensions lies in X-Y, with impedance in Z and orientation; one in
// three leaves the orientation alone to impedance. The controller reads joint angles that are 1 ms old and noisy, its model
// lacks 5 % of the joints' friction, and its torques may change by 1000 N m/s.
//
// For each run and controller: motions from the neighbourhood of the demonstrations' starts, from the edge of {B <= 0}
// (0.01 inside, normalised), and with pushes of 10 and 30 N for 0.1 s across the motion. It writes OUT/robot_drawing.json and
// a figure a run, and prints a table:
//   arrive    share that comes within 0.03 (normalised) of the goal
//   leave     how many are seen outside of {B <= 0}; `largest B` of all
//   |xdot-f|  99th percentile over all ticks after the first 0.2 s, in which the arm gets going, and what is certified
//             (the disturbance margin), both normalised; `covered` is the share of ticks at which the controller's monitor
//             says that the certificate covers the present state
//   path      distance from the motion of x' = f(x) from the same start, mean and largest, in mm on the robot
//   energy    the most that f and the feed-forward drew from the tank, in J
//   tick      microseconds of processor time that a controller's tick takes (f, passive control, torques), median and 99.9 %
//
// Usage: robot_drawing RUN.h5... [--out FOLDER] [--starts N]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <numbers>

#include "drawing.h"
#include "robot_arm.h"
#include "run_table.h"
#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/json_text.h"
#include "s2nnds/core/python_module.h"

namespace s2nnds::experiment {
namespace {

using nlohmann::json;

constexpr double kPushSeconds = 0.1;

// Starts at data units, in {B <= 0}, near those of the demonstrations.
template <int n>
Vectors<n> near_demonstrations(const RunRecord& run, const PolicyInfo& info, std::size_t count) {
  RandomStream random(0, "drawing starts");
  Vectors<n> starts;
  for (std::size_t k = 0; starts.size() < count && k < 1000 * count; ++k) {
    const std::size_t which = k % run.data.demonstrations.size();
    std::array<double, n> x;
    for (int i = 0; i < n; ++i) {
      const double moved = run.data.frame.goal[i] - run.data.frame.goals(static_cast<Eigen::Index>(which), i);
      x[static_cast<std::size_t>(i)] = run.data.demonstrations[which].position(0, i) + moved +
                                       0.05 * info.position_scale * random.normal();
    }
    if (LoadedMotion<n>::in_workspace(x.data()) && LoadedMotion<n>::barrier(x.data()) < -0.02)
      starts.push_back(x);
  }
  return starts;
}

// Starts 0.01 (normalised) inside of {B = 0}, where rays from the goal first meet it.
template <int n>
Vectors<n> at_the_edge(const PolicyInfo& info, std::size_t count) {
  using Motion = LoadedMotion<n>;
  Vectors<n> starts;
  for (std::size_t k = 0; k < count; ++k) {
    // Equal angles, or a spiral over the sphere.
    std::array<double, n> ray = {};
    const double turn = static_cast<double>(k) + 0.5, share = turn / static_cast<double>(count);
    if constexpr (n == 2) {
      ray = {std::cos(2.0 * std::numbers::pi * share), std::sin(2.0 * std::numbers::pi * share)};
    } else {
      const double height = 1.0 - 2.0 * share, angle = std::numbers::pi * (1.0 + std::sqrt(5.0)) * turn;
      const double around = std::sqrt(1.0 - height * height);
      ray = {around * std::cos(angle), around * std::sin(angle), height};
    }
    const auto at = [&](double length) {
      std::array<double, n> x;
      for (std::size_t i = 0; i < n; ++i) x[i] = info.goal[i] + length * info.position_scale * ray[i];
      return x;
    };
    double low = 0.0, high = 0.0;
    while (Motion::barrier(at(high).data()) <= 0.0 && high < 10.0) high += 0.01;
    low = high - 0.01;
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (low + high);
      (Motion::barrier(at(middle).data()) <= 0.0 ? low : high) = middle;
    }
    std::array<double, n> x = at(low), slope;
    double size = 0.0;
    const double nudge = 1e-6 * info.position_scale;
    for (std::size_t i = 0; i < n; ++i) {
      std::array<double, n> above = x, below = x;
      above[i] += nudge;
      below[i] -= nudge;
      slope[i] = Motion::barrier(above.data()) - Motion::barrier(below.data());
      size += slope[i] * slope[i];
    }
    for (std::size_t i = 0; i < n; ++i) x[i] -= 0.01 * info.position_scale * slope[i] / std::sqrt(size);
    starts.push_back(x);
  }
  return starts;
}

struct Controllers {
  std::string name;
  double damping = 100.0;  // N s/m
  bool feed_forward = false;
};

template <int n>
class Drawing {
 public:
  using Motion = LoadedMotion<n>;
  using Passive = PassiveController<Motion>;

  Drawing(const std::string& arm, const Policy& policy)
      : policy_(policy), paper_(policy.info), arm_(arm, RobotArm::Errors{}) {}

  // kg: what the tip shows, on average over the directions of the motion.
  double mass() {
    check(arm_.place(paper_.goal), "robot_drawing: the arm does not reach the goal");
    RandomStream random(0, "mass");
    return mean_effective_mass<n>(arm_.reading(random));
  }

  Drawn draw(const std::array<double, n>& start, const Controllers& kind, double push, std::uint64_t index) {
    check(arm_.place(paper_.on_robot(start.data())), "robot_drawing: the arm does not reach a start");
    const Vectors<n> ideal = ideal_motion<n>(start, policy_.info);
    RandomStream random(1, "robot drawing", index);
    Passive passive(passive_settings(kind));
    TaskSpaceController<RobotArm::joints> task(task_settings());
    check(passive.valid() && task.valid(), "robot_drawing: settings out of range");
    TaskSpaceController<RobotArm::joints>::Goal goal;
    goal.hold_height = n == 2;
    goal.height = paper_.goal[2];
    std::copy_n(RobotArm::pointing_down(), 9, goal.rotation);
    std::copy_n(arm_.posture().begin(), RobotArm::joints, goal.posture);
    const ArmState<RobotArm::joints> still = arm_.reading(random);
    task.reset(still.bias);

    Drawn drawn;
    const double ideal_seconds = 0.005 * static_cast<double>(ideal.size());
    const auto ticks = static_cast<long>((1.5 * ideal_seconds + 3.0) / RobotArm::period);
    const auto push_at = static_cast<long>(0.4 * ideal_seconds / RobotArm::period);
    const auto push_ticks = static_cast<long>(kPushSeconds / RobotArm::period);
    Place pushed = {};
    for (long tick = 0; tick < ticks && !drawn.arrived; ++tick) {
      const ArmState<RobotArm::joints> state = arm_.reading(random);
      const double begin = processor_microseconds();
      const auto command = tool_force(passive, state);
      double force[3] = {};
      std::copy_n(command.force, n, force);
      const auto torques = task.step(state, force, goal);
      drawn.microseconds.push_back(processor_microseconds() - begin);
      if (command.stop != SafeStop::none && drawn.stop.empty()) drawn.stop = in_words(command.stop);
      drawn.energy = std::max(drawn.energy, passive_settings(kind).tank_start - command.tank);
      if (push > 0.0 && tick == push_at) pushed = across(random, push);
      if (tick == push_at + push_ticks) pushed = {};
      arm_.hold(torques.torque, pushed);
      note<n>(drawn, static_cast<double>(tick) * RobotArm::period, tick, paper_, ideal, arm_.position(),
              arm_.velocity());
    }
    drawn.mean_path /= static_cast<double>(std::max(1L, drawn.measured));
    return drawn;
  }

 private:
  typename Passive::Settings passive_settings(const Controllers& kind) const {
    typename Passive::Settings settings;
    settings.metres_per_unit = paper_.metres;
    settings.period = RobotArm::period;
    settings.along = settings.across = kind.damping;
    settings.mass = kind.feed_forward ? mass_ : 0.0;
    return settings;
  }

  TaskSpaceController<RobotArm::joints>::Settings task_settings() const {
    constexpr double known = 0.95;  // of the friction
    TaskSpaceController<RobotArm::joints>::Settings settings;
    for (std::size_t j = 0; j < RobotArm::joints; ++j) {
      settings.coulomb[j] = known * arm_.friction()[j];
      settings.viscous[j] = known * arm_.damping()[j];
      settings.most_torque[j] = j < 4 ? 87.0 : 12.0;
    }
    settings.friction_width = 0.003;
    return settings;
  }

  typename Passive::Command tool_force(Passive& passive, const ArmState<RobotArm::joints>& state) const {
    const auto x = paper_.on_paper({state.position[0], state.position[1], state.position[2]});
    const auto v = paper_.rate_on_paper(tool_velocity(state));
    return passive.step(x.data(), v.data());
  }

  // A push of so many N across the motion, to either side.
  Place across(RandomStream& random, double newton) const {
    const auto x = paper_.on_paper(arm_.position());
    std::array<double, n> f;
    Motion::velocity(x.data(), f.data());
    std::array<double, n> side = {};
    double dot = 0.0, square = 0.0, size = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      side[i] = random.normal();
      dot += side[i] * f[i];
      square += f[i] * f[i];
    }
    for (std::size_t i = 0; i < n; ++i) {
      side[i] -= dot / std::max(square, 1e-300) * f[i];
      size += side[i] * side[i];
    }
    Place push = {};
    for (std::size_t i = 0; i < n; ++i) push[i] = newton * side[i] / std::sqrt(size);
    return push;
  }

  const Policy& policy_;
  Paper<n> paper_;
  RobotArm arm_;

 public:
  double mass_ = 0.0;  // kg: what is fed forward
};

struct Arguments {
  std::vector<std::string> runs;
  std::string out = "runs/robot_drawing";
  std::size_t starts = 20, edge = 24;
  bool draw = true;
};

template <int n>
json draw_run(const RunRecord& run, const Policy& policy, const Arguments& arguments, Table& table) {
  LoadedMotion<n>::load(policy);
  Drawing<n> drawing(S2NNDS_EXPERIMENTS "/robot_arm.xml", policy);
  drawing.mass_ = drawing.mass();
  const double certified =
      policy.info.execution_speed * policy.info.disturbance_margin / policy.info.velocity_scale;
  const Vectors<n> near = near_demonstrations<n>(run, policy.info, arguments.starts),
                   edge = at_the_edge<n>(policy.info, arguments.edge);
  struct Scene {
    std::string name;
    const Vectors<n>& starts;
    double push;
  };
  const Scene scenes[] = {{"demonstrated", near, 0.0},
                          {"edge of {B <= 0}", edge, 0.0},
                          {"pushed, 10 N", near, 10.0},
                          {"pushed, 30 N", near, 30.0}};
  json shown = json::array();
  for (const Controllers& kind :
       {Controllers{"passive", 100.0, false}, Controllers{"feed-forward", 200.0, true}}) {
    for (const Scene& scene : scenes) {
      std::vector<Drawn> all;
      for (std::size_t k = 0; k < scene.starts.size(); ++k) {
        all.push_back(drawing.draw(scene.starts[k], kind, scene.push, k));
        const Drawn& last = all.back();
        if (!last.stop.empty())
          fmt::print(stderr, "{}, {}, start {}: {}\n", run.name, scene.name, k, last.stop);
        shown.push_back({{"control", kind.name},
                         {"scene", scene.name},
                         {"left", last.left},
                         {"arrived", last.arrived},
                         {"path", last.path}});
      }
      table.rows.push_back(row_of(run.name, kind.name, scene.name, all, certified));
    }
  }
  return {{"run", run.name}, {"mass", drawing.mass_}, {"motions", shown}};
}

int run_robot_drawing(const Arguments& arguments) {
  namespace fs = std::filesystem;
  fs::create_directories(arguments.out);
  Table table{.head = table_head(), .rows = {}};
  json found = {{"motions", json::array()}};
  for (const std::string& path : arguments.runs) {
    const RunRecord run = load_run(path);
    const Policy policy = policy_of(run);
    check(policy.info.guarantee == "invariant", "{}: found the guarantee {}, expected invariant", path,
          policy.info.guarantee);
    check(policy.info.dimension == 2 || policy.info.dimension == 3,
          "{}: found a motion in {} dimensions, expected 2 or 3", path, policy.info.dimension);
    json drawn = policy.info.dimension == 2 ? draw_run<2>(run, policy, arguments, table)
                                            : draw_run<3>(run, policy, arguments, table);
    drawn["file"] = fs::absolute(path).string();
    found["motions"].push_back(drawn);
  }
  found["tables"]["drawn"] = table.json();
  const std::string results = (fs::path(arguments.out) / "robot_drawing.json").string();
  write_atomic_file(results, json_text(found), "what was drawn");
  fmt::print("{}", table.text());
  return arguments.draw ? run_python_module("robot_drawing", "plot_drawing", {results}) : 0;
}

}  // namespace
}  // namespace s2nnds::experiment

int main(int argc, char** argv) {
  s2nnds::experiment::Arguments arguments;
  CLI::App app("Draws certified motions with a simulated 7-joint arm.", "robot_drawing");
  app.add_option("runs", arguments.runs, "run files, invariant, in two or three dimensions")->required();
  app.add_option("--out", arguments.out, "folder of results and figures")->capture_default_str();
  app.add_option("--starts", arguments.starts, "near the demonstrations'")->capture_default_str();
  app.add_option("--edge", arguments.edge, "at the edge of {B <= 0}")->capture_default_str();
  app.add_flag("!--no-figures", arguments.draw, "draw nothing");
  CLI11_PARSE(app, argc, argv);
  try {
    return s2nnds::experiment::run_robot_drawing(arguments);
  } catch (const std::exception& error) {
    fmt::print(stderr, "robot_drawing: {}\n", error.what());
    return 2;
  }
}
