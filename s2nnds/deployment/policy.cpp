// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/policy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/data/orientation.h"
#include "s2nnds/problem/interval.h"
#include "s2nnds/verification/rounding_error.h"

namespace s2nnds {

Policy policy_of(const RunRecord& record) {
  const Certificate& certificate = record.certificate;
  const Frame& frame = record.data.frame;
  const Box& workspace = record.problem.workspace;
  Policy policy;
  policy.networks = record.networks;
  PolicyInfo& info = policy.info;
  info.name = record.name;
  info.unit = frame.unit;
  info.frame_name = frame.name;
  info.guarantee = to_string(certificate.guarantee);
  info.statement = certificate.statement;
  const std::string normalised = record.problem.frame == "data" ? "" : "normalised: ";
  info.unsafe_set = normalised + record.problem.unsafe;
  info.initial_set = normalised + record.problem.initial;
  info.weight_hash = certificate.weight_hash.empty() ? weight_hash(record.networks) : certificate.weight_hash;
  info.dimension = record.data.dimension;
  info.phase_start = frame.phase_start;
  info.position_scale = frame.position_scale;
  info.velocity_scale = frame.velocity_scale;
  info.goal.assign(frame.goal.begin(), frame.goal.end());
  // Rounded inwards: what lies within these corners lies within those that were proved.
  const auto in_data = [&](double side, Eigen::Index axis) {
    return frame.goal[axis] + Interval(frame.position_scale) * Interval(side);
  };
  for (Eigen::Index i = 0; i < workspace.dimension(); ++i)
    info.workspace.push_back(in_data(workspace.lower[i], i).upper);
  for (Eigen::Index i = 0; i < workspace.dimension(); ++i)
    info.workspace.push_back(in_data(workspace.upper[i], i).lower);
  info.disturbance_margin = frame.velocity_scale * certificate.disturbance_margin;
  info.convergence_radius = frame.position_scale * certificate.convergence_radius;
  info.float32_error = frame.velocity_scale * float32_error(record.networks.f, workspace);
  if (policy.networks.is_projected()) {
    info.decay = policy.networks.decay / frame.time_scale();
    info.stability_proved = certificate.stability.proved ? 1 : 0;
    // Of the projection's own rounding nothing is known.
    info.float32_error = std::numeric_limits<double>::infinity();
  }
  info.barrier_float32_error = float32_error(record.networks.B, workspace);
  info.barrier_float64_error = float64_error(record.networks.B, workspace);
  if (record.orientation) {
    policy.orientation = record.orientation;
    info.quaternion_order = frame.quaternion_order;
    const Eigen::Vector4d goal = to_order(frame.goal_orientation, frame.quaternion_order);
    info.goal_orientation = {goal.begin(), goal.end()};
    info.orientation_rate = record.orientation->rate;
    info.orientation_error = record.orientation->initial_error;
    info.orientation_proved =
        certificate.guarantee == Guarantee::invariant && certificate.orientation.proved ? 1 : 0;
  }
  const ExecutionCertificate& executed = certificate.execution;
  info.execution = executed.model;
  if (certificate.guarantee != Guarantee::invariant || !executed.invariant) return policy;
  info.executed = 1;
  info.execution_speed = executed.speed;
  info.execution_radius = frame.position_scale * executed.convergence_radius;
  info.most_command = frame.velocity_scale * executed.most_command;
  info.least_speed = executed.least_speed;
  info.most_speed = executed.most_speed;
  // Its gradient is that of the layers.
  if (!executed.shielded || policy.networks.B.head == Head::squared_norm) return policy;
  info.shielded = 1;
  info.shield_band = executed.shield_band;
  info.shield_cone = executed.shield_cone;
  return policy;
}

void check_policy(const Policy& policy) {
  const NetworkWeights &f = policy.networks.f, &V = policy.networks.V, &B = policy.networks.B;
  for (const NetworkWeights* network : {&f, &V, &B}) network->check();
  const PolicyInfo& info = policy.info;
  const Eigen::Index n = info.dimension;
  check(n > 0 && f.input_dimension() == n && f.output_dimension() == n && V.input_dimension() == n &&
            B.input_dimension() == n && V.output_dimension() == 1 && B.output_dimension() == 1 &&
            !is_sum_of_squares(f.head),
        "policy: found f {} -> {}, V {} -> {}, B {} -> {}, expected {} -> {}, {} -> 1, {} -> 1",
        f.input_dimension(), f.output_dimension(), V.input_dimension(), V.output_dimension(),
        B.input_dimension(), B.output_dimension(), n, n, n, n);
  check(std::ssize(info.workspace) == 2 * n, "policy: found a workspace of {} numbers, expected {}",
        info.workspace.size(), 2 * n);
  check(std::ssize(info.goal) == n, "policy: found a goal of {} numbers, expected {}", info.goal.size(), n);
  const auto is_finite = [](double x) { return std::isfinite(x); };
  check(std::all_of(info.workspace.begin(), info.workspace.end(), is_finite) &&
            std::all_of(info.goal.begin(), info.goal.end(), is_finite),
        "policy: found a workspace or a goal that is not finite");
  check(info.position_scale > 0.0 && info.velocity_scale > 0.0 && std::isfinite(info.position_scale) &&
            std::isfinite(info.velocity_scale),
        "policy: found the scales {} and {}, expected finite and positive ones", info.position_scale,
        info.velocity_scale);
  check(info.phase_start >= 0.0 && std::isfinite(info.phase_start) && (info.phase_start == 0.0 || n > 1),
        "policy: found the phase_start {} in {} dimensions, expected a number >= 0", info.phase_start, n);
  check(info.barrier_float32_error >= 0.0 && info.barrier_float64_error >= 0.0,
        "policy: found the bounds {} and {} on the barrier's rounding, expected ones >= 0",
        info.barrier_float32_error, info.barrier_float64_error);
  check((info.decay > 0.0) == policy.networks.is_projected() &&
            (!policy.networks.is_projected() || V.head == Head::diffeomorphism),
        "policy: found a decay of {} 1/s and {} for a V with the head {}, expected both or none, and "
        "diffeomorphism",
        info.decay, policy.networks.decay, to_string(V.head));
  check(policy.orientation.has_value() == !info.quaternion_order.empty(),
        "policy: found an orientation law without the order of quaternions, or the order alone");
  if (policy.orientation) {
    policy.orientation->check(n);
    check(info.goal_orientation.size() == 4, "policy: found a goal orientation of {} numbers, expected 4",
          info.goal_orientation.size());
  }
  const std::string found = weight_hash(policy.networks);
  check(found == info.weight_hash, "policy: found weights {:.16}..., but the certificate speaks of {:.16}...",
        found, info.weight_hash);
}

void check_fits_float(const NetworkWeights& network) {
  const auto check_weight = [](double weight) {
    check(std::isfinite(static_cast<float>(weight)),
          "policy: the weight {} is beyond float's range, use --format header --precision double or pt2",
          weight);
  };
  for (const Layer& layer : network.layers) {
    for (const double weight : layer.weight.reshaped()) check_weight(weight);
    for (const double weight : layer.bias) check_weight(weight);
  }
  check_weight(network.quadratic);
}

void check_plain_motion(const Policy& policy, std::string_view format) {
  check(!policy.networks.is_projected() && policy.networks.V.head != Head::diffeomorphism,
        "{}: found a projected f or a V that is a diffeomorphism, expected --format header or onnx", format);
}

Eigen::Vector4d goal_orientation_of(const PolicyInfo& info) {
  return from_order(Eigen::Map<const Eigen::Vector4d>(info.goal_orientation.data()), info.quaternion_order);
}

Points layers_at_origin(const NetworkWeights& network) {
  NetworkWeights layers = network;
  layers.head = Head::plain;
  return layers.value(Points::Zero(1, network.input_dimension()));
}

}  // namespace s2nnds
