// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/displacement.h"

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/interval.h"

namespace s2nnds {
namespace {

constexpr double kRamp = 0.25;  // share of [0, 1] over which S's slope grows, and over which it falls
static_assert(Displacement::slope * (1.0 - kRamp) == 1.0);

// S on [0, 1]: the integral of `step_slope`.
double step(double t) {
  if (t > 1.0 - kRamp) return 1.0 - step(1.0 - t);
  if (t > kRamp) return Displacement::slope * (t - 0.5 * kRamp);
  const double u = t / kRamp;
  return Displacement::slope * kRamp * u * u * u * (1.0 - 0.5 * u);
}
double step_slope(double t) {
  const double u = std::fmin(1.0, std::fmin(t, 1.0 - t) / kRamp);
  return Displacement::slope * u * u * (3.0 - 2.0 * u);
}

}  // namespace

Displacement::Displacement(const Vector& center, double inner, double outer)
    : center_(center), inner_(inner), outer_(outer) {
  check(
      center.size() > 0 && center.allFinite() && inner >= 0.0 && inner < outer && std::isfinite(outer),
      "displacement: found the radii {} and {} around {} coordinates, expected 0 <= inner < outer and finite "
      "numbers",
      inner, outer, center.size());
}

double Displacement::lipschitz() const {
  return (Interval(4.0) / (Interval(3.0) * (Interval(outer_) - inner_))).upper;
}

double Displacement::largest(double stretch) const {
  return (Interval(stretch) * Interval(0.75) * (Interval(outer_) - inner_)).lower;
}

double Displacement::value(const double* x) const {
  double square = 0.0;
  for (Eigen::Index i = 0; i < places(); ++i) square += (x[i] - center_[i]) * (x[i] - center_[i]);
  const double distance = std::sqrt(square);
  if (distance >= outer_) return 0.0;
  if (distance <= inner_) return 1.0;
  return step((outer_ - distance) / (outer_ - inner_));
}

double Displacement::derivative(const double* x, const double* direction) const {
  double square = 0.0, along = 0.0;
  for (Eigen::Index i = 0; i < places(); ++i) {
    square += (x[i] - center_[i]) * (x[i] - center_[i]);
    along += (x[i] - center_[i]) * direction[i];
  }
  const double distance = std::sqrt(square), width = outer_ - inner_;
  if (distance >= outer_ || distance <= inner_) return 0.0;
  return -step_slope((outer_ - distance) / width) / width * along / distance;
}

void Displacement::check_shapes(const Points& x, const Vector& p) const {
  check(x.cols() >= places() && p.size() == places(),
        "displacement: found states of {} and a displacement of {} coordinates, expected {}", x.cols(),
        p.size(), places());
  check(p.norm() * lipschitz() < 1.0, "displacement: found one of {}, expected less than {}", p.norm(),
        largest(1.0));
}

Vector Displacement::bump(const Points& x) const {
  check(x.cols() >= places(), "displacement: found states of {} coordinates, expected {}", x.cols(),
        places());
  Vector psi(x.rows());
  for (Eigen::Index k = 0; k < x.rows(); ++k) psi[k] = value(x.row(k).data());
  return psi;
}

Points Displacement::image(const Points& y, const Vector& p) const {
  check_shapes(y, p);
  Points x = y;
  if (p.isZero(0.0)) return x;
  for (Eigen::Index k = 0; k < y.rows(); ++k) {
    const double psi = value(y.row(k).data());
    if (psi != 0.0) x.row(k).head(places()) += psi * p.transpose();
  }
  return x;
}

// s = psi(x - s p), in [0, 1]; 0 for NaN.
double Displacement::share_moved(const double* x, const Vector& p) const {
  Vector y = Eigen::Map<const Vector>(x, places());
  double low = 0.0, high = 1.0, s = value(x);
  for (int i = 0; i < 100; ++i) {
    y = Eigen::Map<const Vector>(x, places()) - s * p;
    const double excess = s - value(y.data());
    (excess > 0.0 ? high : low) = s;
    if (std::abs(excess) <= 1e-16) break;
    const double newton = s - excess / (1.0 + derivative(y.data(), p.data()));
    const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
    if (next == s || !(high > low)) break;
    s = next;
  }
  return s;
}

Points Displacement::preimage(const Points& x, const Vector& p) const {
  check_shapes(x, p);
  Points y = x;
  if (p.isZero(0.0)) return y;
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    // T_p maps the outside of the ball onto itself.
    const double* place = x.row(k).data();
    if (!((Eigen::Map<const Vector>(place, places()) - center_).norm() < outer_)) continue;
    y.row(k).head(places()) -= share_moved(place, p) * p.transpose();
  }
  return y;
}

Points Displacement::pushed(const Points& y, const Points& v, const Vector& p) const {
  check_shapes(y, p);
  check(v.rows() == y.rows() && v.cols() == y.cols(),
        "displacement: found velocities [{}, {}], expected [{}, {}]", v.rows(), v.cols(), y.rows(), y.cols());
  Points result = v;
  if (p.isZero(0.0)) return result;
  for (Eigen::Index k = 0; k < y.rows(); ++k) {
    const double rate = derivative(y.row(k).data(), v.row(k).data());
    if (rate != 0.0) result.row(k).head(places()) += rate * p.transpose();
  }
  return result;
}

}  // namespace s2nnds
