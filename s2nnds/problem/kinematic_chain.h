// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/problem/interval.h"
#include "s2nnds/problem/rotation.h"

namespace s2nnds {

// Where a joint's row of a Denavit-Hartenberg table stands for its frame: modified (Craig), Rx(alpha) Tx(a) Rz(theta)
// Tz(d), joint i turns about the z axis of frame i; standard, Rz(theta) Tz(d) Tx(a) Rx(alpha), about that of frame i - 1.
enum class DhConvention { modified, standard };

// A frame of a chain as seen from the world, in doubles or in intervals that hold the exact values.
template <typename Number>
struct FramePose {
  std::array<Number, 9> axes;    // row by row: [3 i + j] is coordinate i of axis j
  std::array<Number, 3> origin;  // in the table's unit of length
  std::array<Number, 3> step;    // the origin as seen from that of the frame before

  // The point `at` of the frame, as seen from its origin but along the world's axes.
  std::array<Number, 3> turned(const Eigen::Vector3d& at) const;
};

// A straight line between two points of one frame.
struct FrameSegment {
  Eigen::Index frame = 0;
  Eigen::Vector3d start, end;  // as seen from the frame
};

// Revolute joints one after the other on a base that does not move. Frame 0 is the base, frame i moves with joint i.
class KinematicChain {
 public:
  // Rows [a, alpha, d, theta] for each joint, lengths in one unit and angles in rad; theta is added to the joint's angle.
  // The base lies at `base` [3] in the world, turned by `rotation` [3, 3]. Throws Error unless there are rows of four
  // finite numbers.
  KinematicChain(const std::vector<std::vector<double>>& rows, DhConvention convention, const Vector& base,
                 const Rotation& rotation);

  Eigen::Index joints() const { return static_cast<Eigen::Index>(links_.size()); }  // n
  // Frames 0 to n at joint angles [n] in rad, of doubles or of intervals.
  template <typename Number>
  std::vector<FramePose<Number>> frames(const std::vector<Number>& angles) const;
  // The frame whose z axis joint i in 1..n turns about; the axis passes through its origin.
  Eigen::Index axis_of(Eigen::Index joint) const;
  // From the origin of frame i - 1 to that of frame i, i in 1..n, in the first frame in which neither moves; up to rounding.
  FrameSegment link(Eigen::Index i) const;
  // How far, at most, a point of a frame ever is from the axis of each joint [n]: what it moves by for every rad. Exactly
  // 0 for joints that never move it.
  std::vector<double> reaches(Eigen::Index frame, const Eigen::Vector3d& at) const;

 private:
  struct Link {
    double a, d, theta, cos_alpha, sin_alpha;
    Interval exact_cos, exact_sin;  // of alpha
  };
  // Cosine and sine of its alpha.
  template <typename Number>
  static std::pair<Number, Number> twist(const Link& link);

  std::vector<Link> links_;
  DhConvention convention_;
  Eigen::Vector3d base_;
  Rotation rotation_;
};

}  // namespace s2nnds
