// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/orientation_reading.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/data/orientation.h"

namespace s2nnds {
namespace {

constexpr double kNormTolerance = 0.1, kMatrixTolerance = 0.05;
constexpr double kLargestStep = M_PI / 3;
constexpr double kUnmixedStep = M_PI / 12;  // as small is a step that the other order explains
constexpr double kLargestTurn = 170.0 * M_PI / 180.0;

std::string other_order(const std::string& order) { return order == "wxyz" ? "xyzw" : "wxyz"; }

// The recordings' orientations, one after another.
class Reader {
 public:
  Reader(const std::string& order) : order_(order) {}

  void read(Recording& recording) {
    recording_ = &recording;
    const Points raw = recording.orientation;
    const bool matrices = raw.cols() == 9;
    check(raw.rows() == recording.samples() && (matrices || raw.cols() == 4),
          "{}: found orientations [{}, {}] for {} positions; expected quaternions [{}, 4] or rotation "
          "matrices [{}, 9]",
          recording.where, raw.rows(), raw.cols(), recording.samples(), recording.samples(),
          recording.samples());
    Points unit = Points::Constant(raw.rows(), 4, std::numeric_limits<double>::quiet_NaN());
    Eigen::Index before = -1;
    bool negated = false;
    for (Eigen::Index i = 0; i < raw.rows(); ++i) {
      if (!raw.row(i).allFinite()) continue;
      Eigen::Vector4d q = matrices ? of_matrix(raw, i) : of_quaternion(raw, i);
      if (before >= 0) {
        const Eigen::Vector4d last = unit.row(before).transpose();
        const bool negate = q.dot(last) < 0.0;
        if (negate) q = -q;
        if (negate != negated && !matrices) ++flips_;
        negated = negate;
        check_step(last, q, raw, i);
      }
      unit.row(i) = q.transpose();
      before = i;
    }
    if (before >= 0) check_turn(unit, unit.row(before).transpose());
    recording.orientation = std::move(unit);
  }

  std::string report(bool matrices) const {
    if (matrices) return "orientations from rotation matrices";
    std::string text = fmt::format("orientations from quaternions {}", order_);
    if (flips_ > 0) text += fmt::format(", {} change(s) between q and -q undone", flips_);
    if (largest_deviation_ > 1e-3)
      text += fmt::format(", norms that differ from 1 by up to {:.2g} made 1", largest_deviation_);
    return text;
  }

 private:
  Eigen::Vector4d of_quaternion(const Points& raw, Eigen::Index i) {
    const double norm = raw.row(i).norm();
    check(std::abs(norm - 1.0) <= kNormTolerance,
          "{}: found a quaternion of norm {:.3g}; expected 1 to within {:g}", recording_->place(i), norm,
          kNormTolerance);
    largest_deviation_ = std::max(largest_deviation_, std::abs(norm - 1.0));
    return from_order(raw.row(i).transpose(), order_) / norm;
  }

  // The nearest rotation.
  Eigen::Vector4d of_matrix(const Points& raw, Eigen::Index i) const {
    const Eigen::Matrix3d m = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&raw(i, 0));
    const double off = (m * m.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    check(off <= kMatrixTolerance && m.determinant() > 0.0,
          "{}: found a matrix with determinant {:.3g} whose rows are orthonormal but for {:.2g}; expected a "
          "rotation matrix, row by row",
          recording_->place(i), m.determinant(), off);
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
    const Eigen::Quaterniond q(nearest);
    return Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()).normalized();
  }

  void check_step(const Eigen::Vector4d& last, const Eigen::Vector4d& q, const Points& raw,
                  Eigen::Index i) const {
    const double step = angle_between(last, q);
    if (step <= kLargestStep) return;
    if (raw.cols() == 4) {
      const Eigen::Vector4d other = from_order(raw.row(i).transpose().normalized(), other_order(order_));
      const double unmixed = angle_between(last, other);
      check(!(unmixed <= kUnmixedStep),
            "{}: found a turn of {:.0f} degrees from the sample before, but of {:.2g} if the numbers were {} "
            "from here on; expected one order throughout (data.quaternion_order)",
            recording_->place(i), degrees(step), degrees(unmixed), other_order(order_));
    }
    fail("{}: found a turn of {:.0f} degrees from the sample before; expected at most {:.0f}",
         recording_->place(i), degrees(step), degrees(kLargestStep));
  }

  void check_turn(const Points& unit, const Eigen::Vector4d& last) const {
    for (Eigen::Index i = 0; i < unit.rows(); ++i) {
      if (!unit.row(i).allFinite()) continue;
      const double turn = angle_between(last, unit.row(i).transpose());
      check(turn < kLargestTurn,
            "{}: found an orientation turned by {:.0f} degrees from the recording's last one; expected less "
            "than {:.0f}, since no law can lead from there to it without a jump nearby",
            recording_->place(i), degrees(turn), degrees(kLargestTurn));
    }
  }

  const std::string& order_;
  const Recording* recording_ = nullptr;
  Eigen::Index flips_ = 0;
  double largest_deviation_ = 0.0;
};

}  // namespace

void make_unit_orientations(RecordingSet& set, const std::string& order) {
  Reader reader(order);
  bool matrices = false;
  for (Recording& recording : set.recordings) {
    matrices = recording.orientation.cols() == 9;
    reader.read(recording);
  }
  set.report.push_back(reader.report(matrices));
}

}  // namespace s2nnds
