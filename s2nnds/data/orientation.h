// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "s2nnds/core/points.h"

namespace s2nnds {

// Orientations are unit quaternions q = (w, x, y, z), one a row [M, 4]: the rotation that takes the frame of what moves
// to the frame of the data. q and -q are one orientation. A rotation vector r [3] has the rotation's axis as its
// direction and its angle, in radians, as its length; exp(r) is its quaternion.

// Users write quaternions in the order "xyzw" or "wxyz". Where w, x, y and z stand there; the orientation that four such
// numbers are; the numbers of an orientation. All throw Error for another order.
std::array<Eigen::Index, 4> places_in(const std::string& order);
Eigen::Vector4d from_order(const Eigen::Vector4d& numbers, const std::string& order);
Eigen::Vector4d to_order(const Eigen::Vector4d& q, const std::string& order);

// a b, the rotation b followed by a. All of these take and give (w, x, y, z).
Eigen::Vector4d product(const Eigen::Vector4d& a, const Eigen::Vector4d& b);
Eigen::Vector4d inverse(const Eigen::Vector4d& q);  // of a unit quaternion

// exp(r), with a part w >= 0 where |r| <= pi.
Eigen::Vector4d quaternion_of(const Eigen::Vector3d& r);
// log(q), the shortest one: |r| <= pi. Smooth where |r| < pi.
Eigen::Vector3d rotation_vector(const Eigen::Vector4d& q);
// log(goal^-1 q) of each row of `orientation` [M, 4], as seen from the goal's orientation: [M, 3].
Points rotation_vectors(const Eigen::Vector4d& goal, const Points& orientation);
// goal exp(r) of each row of r [M, 3]: [M, 4].
Points orientations(const Eigen::Vector4d& goal, const Points& r);

// The angle of the rotation from a to b, in [0, pi] rad.
double angle_between(const Eigen::Vector4d& a, const Eigen::Vector4d& b);

// R with q = (w, x, y, z) as a matrix.
Eigen::Matrix3d rotation_matrix(const Eigen::Vector4d& q);

// The left Jacobian J of the exponential: d/dt exp(r) = [J(r) dr/dt]x exp(r), so that J(r) dr/dt is the angular
// velocity in the frame that exp(r) maps to. J(r) = I + (1 - cos a) / a^2 [r]x + (a - sin a) / a^3 [r]x^2, a = |r|
// (Sola, Deray, Atchuthan, arXiv 1812.01537, eq. 145).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& r);

// The orientation from which the sum of squared sines of half the angles to all rows is least (Markley et al., 2007).
Eigen::Vector4d mean_orientation(const Points& orientation);

double degrees(double radians);  // 180 / pi times as much

}  // namespace s2nnds
