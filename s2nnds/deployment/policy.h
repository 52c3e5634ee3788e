// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "s2nnds/networks/network_weights.h"
#include "s2nnds/runs/run_record.h"

namespace s2nnds {

// What an exported policy carries besides its networks. Positions are the user's: in the data's unit and frame,
// as the robot reports them; velocities and margins are in that unit (of length, and per second). The networks
// compute in normalised coordinates z = (x - goal) / position_scale, and their velocity f(z) * velocity_scale is
// the data's: this is the only place that says so. Exporters subtract in double, since single precision would
// lose digits far from the origin.
struct PolicyInfo {
  std::string name;            // of the configuration
  std::string unit;            // of length: "mm", "m"; "" when unknown
  std::string frame_name;      // of the positions' frame: "base_link"; "" when not told
  std::string guarantee;       // "none", "sampled", "conformal", "proved" or "invariant"
  std::string statement;       // what holds, in words
  std::string unsafe_set;      // Xu in words, as the configuration wrote it
  std::string initial_set;     // X0 in words, as the configuration wrote it
  std::string weight_hash;     // SHA-256, in hexadecimal, of the networks that the guarantee speaks of
  std::int64_t dimension = 0;  // n, of states
  double phase_start = 0.0;    // the last coordinate is a phase that starts here; 0: all are those of a place
  std::vector<double> goal;    // [n]
  double position_scale = 1.0;      // `unit` per normalised length, > 0
  double velocity_scale = 1.0;      // `unit` per second and normalised velocity, > 0
  std::vector<double> workspace;    // [2 n]: lower corner, upper corner, within what was proved
  double disturbance_margin = 0.0;  // certified for x' = velocity(x) + w, |w| <= this; 0: none
  double convergence_radius = 0.0;  // such motions reach this distance from the goal
  double float32_error = 0.0;       // bound on |error| of the velocity in float, in the workspace
  // The same of the barrier, in float and in double: `safe` compares the barrier with minus the one that applies, so
  // that it is never true where the exact barrier is positive.
  double barrier_float32_error = 0.0, barrier_float64_error = 0.0;
  // The motion as a robot executes it (ExecutionCertificate); nothing of it is certified unless `executed` is 1.
  std::string execution;          // how, in words
  std::int64_t executed = 0;      // 1: motions executed so that start in the safe set stay in it
  double execution_speed = 1.0;   // factor on the velocity with which it is executed
  double execution_radius = 0.0;  // such motions reach this distance from the goal; infinite: not shown
  double most_command = 0.0;      // above the speed of every command
  double least_speed = 0.0, most_speed = 0.0;   // certified factors; both 0: not looked for
  std::int64_t shielded = 0;                    // 1: a shield keeps any velocity safe
  double shield_band = 0.0, shield_cone = 0.0;  // of the barrier, and per normalised length

  // Of a projected f; none of it is visited otherwise.
  double decay = 0.0;                 // 1/s: V falls at least as fast as e^(-decay t); 0: f is not projected
  std::int64_t stability_proved = 0;  // 1: every motion converges to the goal, from anywhere

  // Where poses move; none of it is visited otherwise. Orientations are in the user's order.
  std::string quaternion_order = {};          // xyzw or wxyz; "" where nothing turns
  std::vector<double> goal_orientation = {};  // [4] in that order
  double orientation_rate = 0.0;              // k, 1/s
  std::int64_t orientation_proved = 0;  // 1: it converges from every safe start with an error up to this
  double orientation_error = 0.0;       // rad

  // Calls visit(name, value, meaning) for every field, so that no exporter lists them again; a value is a
  // std::string, std::int64_t, double or std::vector<double>.
  template <typename Visit>
  void visit(Visit&& visit) const {
    visit("name", name, "of the configuration");
    visit("unit", unit, "of length");
    visit("frame_name", frame_name, "of the frame of all positions");
    visit("guarantee", guarantee, "none, sampled, conformal, proved or invariant");
    visit("statement", statement, "what holds, in words");
    visit("unsafe_set", unsafe_set, "the obstacle, as the configuration wrote it");
    visit("initial_set", initial_set, "where motions start, as the configuration wrote it");
    visit("weight_hash", weight_hash, "SHA-256 of the networks that the guarantee speaks of");
    visit("dimension", dimension, "of positions and velocities");
    if (phase_start > 0.0)
      visit("phase_start", phase_start, "of the last coordinate, a phase: where it starts");
    visit("goal", goal, "where motions end");
    visit("position_scale", position_scale, "(position - goal) / position_scale = normalised");
    visit("velocity_scale", velocity_scale, "normalised * velocity_scale = velocity");
    visit("workspace", workspace, "lower corner, upper corner");
    visit("disturbance_margin", disturbance_margin,
          "certified for x' = velocity(x) + w, |w| <= this; 0: none");
    visit("convergence_radius", convergence_radius, "such motions reach this distance from the goal");
    visit("float32_error", float32_error, "bound on |error| of the velocity in float, in the workspace");
    visit("barrier_float32_error", barrier_float32_error, "the same of the barrier in float");
    visit("barrier_float64_error", barrier_float64_error, "the same of the barrier in double");
    visit("execution", execution, "how the robot executes the motion");
    visit("executed", executed, "1: certified for that: motions that start in the safe set stay in it");
    visit("execution_speed", execution_speed, "factor on the velocity in it");
    visit("execution_radius", execution_radius, "such motions reach this distance from the goal");
    visit("most_command", most_command, "no command is faster");
    visit("least_speed", least_speed, "certified factors on the velocity");
    visit("most_speed", most_speed, "both 0: not looked for");
    visit("shielded", shielded, "1: a shield is certified");
    visit("shield_band", shield_band, "it acts where the barrier is above minus this");
    visit("shield_cone", shield_cone, "bound on the change of the barrier's gradient, normalised");
    if (decay > 0.0) {
      visit("decay", decay, "1/s: the Lyapunov function falls at least as fast as exp(-decay t)");
      visit("stability_proved", stability_proved, "1: every motion converges to the goal, from anywhere");
    }
    if (quaternion_order.empty()) return;
    visit("quaternion_order", quaternion_order, "of all orientations");
    visit("goal_orientation", goal_orientation, "where orientations end, in that order");
    visit("orientation_rate", orientation_rate, "1/s: an orientation error falls as exp(-rate t)");
    visit("orientation_proved", orientation_proved,
          "1: from safe starts with an orientation_error up to this");
    visit("orientation_error", orientation_error, "rad: it converges to goal_orientation");
  }
};

// What is exported.
struct Policy {
  Networks networks;                               // f, V and B, in normalised coordinates
  PolicyInfo info;                                 // units, scales and the guarantee
  std::optional<OrientationLaw> orientation = {};  // of poses
};

// The policy of a stored run, with the bounds on rounding of its weights.
Policy policy_of(const RunRecord& record);

// Throws Error unless the networks map n -> n, n -> 1 and n -> 1, weights are finite, goal, workspace and scales
// fit them, and the weights are those that the certificate speaks of: what was certified is what ships.
void check_policy(const Policy& policy);

// Throws Error unless every weight is within float's range.
void check_fits_float(const NetworkWeights& network);

// Throws Error, naming the format, where f is projected or V a diffeomorphism, which it cannot hold.
void check_plain_motion(const Policy& policy, std::string_view format);

// The goal's orientation (w, x, y, z) of a policy of poses.
Eigen::Vector4d goal_orientation_of(const PolicyInfo& info);

// N(0) of the layers alone, [1, m]: what all heads but plain subtract.
Points layers_at_origin(const NetworkWeights& network);

}  // namespace s2nnds
