// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/local_polynomial.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "s2nnds/data/readers.h"

namespace s2nnds {

LocalParabola fit_parabola(const Vector& time, const Points& position, Eigen::Index first, Eigen::Index count,
                           double at) {
  // Times about `at` in units of the window, so that the normal equations are well scaled.
  const double scale = std::max(at - time[first], time[first + count - 1] - at);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, Eigen::Dynamic> right(3, position.cols());
  right.setZero();
  Eigen::Index nearest = first;
  for (Eigen::Index i = first; i < first + count; ++i) {
    const double u = (time[i] - at) / scale;
    const Eigen::Vector3d basis(1, u, u * u);
    normal += basis * basis.transpose();
    right += basis * position.row(i);
    if (std::abs(time[i] - at) < std::abs(time[nearest] - at)) nearest = i;
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
  const Eigen::Matrix<double, 3, Eigen::Dynamic> solution = solver.solve(right);
  const double u = (time[nearest] - at) / scale;
  const Eigen::Vector3d basis(1, u, u * u);
  return {solution.row(0), solution.row(1) / scale, basis.dot(solver.solve(basis))};
}

namespace {

constexpr Eigen::Index kFewest = 5;  // samples of a window
constexpr double kMost = 32;         // samples of a window; of more, means of neighbours do as well

// The mean times and positions of every `group` samples.
void average(const Vector& time, const Points& position, Eigen::Index group, Vector& times, Points& means) {
  const Eigen::Index groups = time.size() / group;  // the last one takes the rest
  times.resize(groups);
  means.resize(groups, position.cols());
  for (Eigen::Index g = 0; g < groups; ++g) {
    const Eigen::Index count = g + 1 < groups ? group : time.size() - g * group;
    times[g] = time[g * group] + (time.segment(g * group, count).array() - time[g * group]).mean();
    means.row(g) = position.middleRows(g * group, count).colwise().mean();
  }
}

// The parabola around every sample.
std::vector<LocalParabola> fit_all(const Vector& time, const Points& position, double width) {
  const Eigen::Index samples = time.size();
  const Eigen::Index most = std::max(kFewest, samples / 10);
  std::vector<LocalParabola> fits;
  fits.reserve(static_cast<std::size_t>(samples));
  const double half = width / 2 * (1 + 1e-9);  // with a sample that rounding puts just outside
  Eigen::Index low = 0, high = 0;              // samples within it
  for (Eigen::Index i = 0; i < samples; ++i) {
    while (time[i] - time[low] > half) ++low;
    while (high + 1 < samples && time[high + 1] - time[i] <= half) ++high;
    // As many to both sides as the side with fewer has, so that the middle of the window is the sample.
    const Eigen::Index reach = std::clamp(std::min(i - low, high - i), (kFewest - 1) / 2, (most - 1) / 2);
    const Eigen::Index first = std::clamp<Eigen::Index>(i - reach, 0, samples - kFewest);
    const Eigen::Index last = std::clamp<Eigen::Index>(i + reach, kFewest - 1, samples - 1);
    fits.push_back(fit_parabola(time, position, first, last - first + 1, time[i]));
  }
  return fits;
}

}  // namespace

SmoothDerivative smooth_derivative(const Vector& time, const Points& position, double width) {
  const Eigen::Index samples = position.rows();
  if (samples < kFewest) return {differentiate(time, position), 0};
  const double in_window = static_cast<double>(samples) * width / (time[samples - 1] - time[0]);
  const auto group = std::max<Eigen::Index>(
      1, std::min(static_cast<Eigen::Index>(in_window / kMost), samples / (10 * kFewest)));
  Vector times;
  Points means;
  average(time, position, group, times, means);
  const std::vector<LocalParabola> fits = fit_all(times, means, width);
  SmoothDerivative result{Points(samples, position.cols()), 0};
  double squares = 0, weight = 0;
  for (Eigen::Index i = 0; i < samples; ++i) {
    const Eigen::Index g = std::min(i / group, times.size() - 1);
    const LocalParabola& fit = fits[static_cast<std::size_t>(g)];
    // Between the middles of two groups the slope is interpolated.
    const Eigen::Index next =
        std::clamp<Eigen::Index>(time[i] < times[g] ? g - 1 : g + 1, 0, times.size() - 1);
    const double share = next == g ? 0 : (time[i] - times[g]) / (times[next] - times[g]);
    result.velocity.row(i) = (1 - share) * fit.slope + share * fits[static_cast<std::size_t>(next)].slope;
    squares += (position.row(i) - fit.value - (time[i] - times[g]) * fit.slope).squaredNorm();
    weight += (1 - fit.leverage / static_cast<double>(group)) * static_cast<double>(position.cols());
  }
  result.noise = weight > 0 ? std::sqrt(squares / weight) : 0;
  return result;
}

}  // namespace s2nnds
