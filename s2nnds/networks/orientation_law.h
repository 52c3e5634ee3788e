// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/core/points.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// How the orientation q follows the position. With r = log(q_goal^-1 q) and z the normalised position, whose velocity is
// zdot,
//   rdot = J_psi(z) zdot - k (r - psi(z)),
// so that e = r - psi(z) obeys edot = -k e: the orientation comes to the goal's whatever the position does, as long as
// |r| < pi. psi is 0 at the goal.
struct OrientationLaw {
  NetworkWeights psi;          // R^n -> R^3, normalised position -> rotation vector (rad), psi(0) = 0
  double rate = 1.0;           // k, 1/s, > 0
  double initial_error = 0.0;  // largest |e| of a start that the certificate speaks of, rad, in (0, pi)

  // Throws Error unless psi maps [n] to [3] and is 0 at the origin by its head, and the numbers are in their ranges.
  void check(Eigen::Index dimension) const;
  std::string hash() const;  // SHA-256, in hexadecimal, of psi as weight_hash() takes networks

  // The angular velocity [N, 3], rad/s, at normalised positions z [N, n] with velocities zdot [N, n] (per second) and
  // orientations [N, 4] (w, x, y, z), in the frame of the data: q' = 1/2 (0, omega) q. That is R(q_goal) J(r) rdot with
  // the left Jacobian J of the exponential.
  Points angular_velocity(const Eigen::Vector4d& goal, const Points& z, const Points& zdot,
                          const Points& orientation) const;

  // The orientations [M, 4] of a motion that starts with the orientation `start`, at normalised positions z [M, n] at
  // `time` [M] (s): r = psi(z) + exp(-k (t - t[0])) e(0), which solves the law exactly.
  Points follow(const Eigen::Vector4d& goal, const Vector& time, const Points& z,
                const Eigen::Vector4d& start) const;
};

}  // namespace s2nnds
