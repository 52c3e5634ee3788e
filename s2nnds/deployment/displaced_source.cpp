// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/displaced_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/interval.h"
#include "s2nnds/verification/lipschitz_bound.h"

namespace s2nnds {
namespace {

// Normalised: above how far the place that the header finds for T_p^-1(x) may lie from the exact one. Its search ends at
// 1e-13 of |p|, or says that it did not; the rest is rounding of doubles.
constexpr double kInverseError = 1e-10;

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:#}", value) : "HUGE_VAL"; }
std::string numbers(const std::vector<double>& values) {
  std::vector<std::string> all;
  for (const double value : values) all.push_back(number(value));
  return fmt::format("{{{}}}", fmt::join(all, ", "));
}

// {0}: places, {1}: |p|, {2}: box, {3}: center, {4}: inner, {5}: outer, {6}: margin, {7}: B's error, {8}: slope.
constexpr const char* kDisplaced =
    R"(// ---- An obstacle displaced by p [displaced_places], in `unit`: from one certificate, by a change of coordinates
// T_p(x) = x + p psi(x), with psi = 1 around the obstacle and 0 beyond a ball around it. What is proved of velocity(x) and
// barrier(x) where the obstacle was holds of velocity(x, p) and barrier(x, p) where it is, for every p with displaced(p).
inline constexpr int displaced_places = {0};                 // coordinates that p has
inline constexpr double displacement_radius = {1};           // |p| <= this, and
inline constexpr double displacement_box[{0}] = {2};         // |p_i| <= these
inline constexpr double displaced_disturbance_margin = {6};  // certified for x' = velocity(x, p) + w, |w| <= this; 0: none
inline constexpr double displaced_barrier_error = {7};       // of barrier(x, p), by the inverse of T_p

// Whether the displacement p [displaced_places] is one of those that are certified. False for NaN.
inline bool displaced(const double* p) noexcept {{
  double square = 0;
  for (int i = 0; i < displaced_places; ++i) {{
    if (!(std::fabs(p[i]) <= displacement_box[i])) return false;
    square += p[i] * p[i];
  }}
  return std::sqrt(square) <= displacement_radius * (1 - 1e-12);
}}

namespace detail {{

inline constexpr double ball_center[displaced_places] = {3};  // normalised, of the obstacle

// psi at the normalised position z, and `factor`: its gradient is factor (z - ball_center).
inline double bump(const double* z, double& factor) noexcept {{
  constexpr double inner = {4}, outer = {5}, slope = {8}, ramp = 0.25;
  double square = 0;
  for (int i = 0; i < displaced_places; ++i) square += (z[i] - ball_center[i]) * (z[i] - ball_center[i]);
  const double distance = std::sqrt(square), t = (outer - distance) / (outer - inner);
  factor = 0;
  if (distance >= outer) return 0;
  if (distance <= inner) return 1;
  const double edge = std::fmin(t, 1 - t), u = std::fmin(1.0, edge / ramp);
  factor = -slope * u * u * (3 - 2 * u) / ((outer - inner) * distance);
  const double rise = edge < ramp ? slope * ramp * u * u * u * (1 - u / 2) : slope * (edge - ramp / 2);
  return t > 0.5 ? 1 - rise : rise;
}}

// y = T_p^-1(x), as y = x - s p with s = psi(y): what is sought grows with s, so Newton's method is kept in an interval.
struct Displaced {{
  double y[dimension], psi, factor = 0;
  bool found;
  Displaced(const double* x, const double* p) noexcept {{
    const Normalised<double> at(x);
    double q[displaced_places], z[displaced_places], low = 0, high = 1;
    for (int i = 0; i < displaced_places; ++i) q[i] = p[i] / position_scale;
    double s = bump(at.z, factor), excess = 0;
    for (int round = 0; round < 60; ++round) {{
      double rate = 0;
      for (int i = 0; i < displaced_places; ++i) z[i] = at.z[i] - s * q[i];
      excess = s - bump(z, factor);
      if (std::fabs(excess) <= 2e-16) break;
      (excess > 0 ? high : low) = s;
      for (int i = 0; i < displaced_places; ++i) rate += factor * q[i] * (z[i] - ball_center[i]);
      const double newton = s - excess / (1 + rate);
      const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
      if (next == s) break;
      s = next;
    }}
    found = std::fabs(excess) <= 1e-13;
    psi = s;
    for (int i = 0; i < dimension; ++i) y[i] = x[i];
    if (!(s == 0))
      for (int i = 0; i < displaced_places; ++i) y[i] -= s * p[i];
  }}
}};

inline bool displaced_velocity(const double* x, const double* p, const double* rate, double* v) noexcept {{
  if (!displaced(p)) {{
    for (int i = 0; i < dimension; ++i) v[i] = 0;
    return false;
  }}
  const Displaced at(x, p);
  velocity(at.y, v);
  const Normalised<double> y(at.y);
  double along = 0;
  for (int i = 0; i < displaced_places; ++i) along += at.factor * (y.z[i] - ball_center[i]) * v[i] / position_scale;
  for (int i = 0; i < displaced_places; ++i) v[i] += along * p[i] + at.psi * rate[i];
  return true;
}}
}}  // namespace detail

// v [dimension] = the velocity at x [dimension] where the obstacle rests, displaced by p [displaced_places]. Where p is not one
// of displaced(p), v is 0; returns whether it is. A jump of p needs a look at safe(x, p), since x may then be in no safe set.
inline bool velocity(const double* x, const double* p, double* v) noexcept {{
  constexpr double rest[displaced_places] = {{}};
  return detail::displaced_velocity(x, p, rest, v);
}}

// The Lyapunov function at x [dimension] where the obstacle is displaced by p, one of displaced(p).
inline double lyapunov(const double* x, const double* p) noexcept {{ return lyapunov(detail::Displaced(x, p).y); }}

// The barrier at x [dimension] where the obstacle is displaced by p, one of displaced(p).
inline double barrier(const double* x, const double* p) noexcept {{ return barrier(detail::Displaced(x, p).y); }}

// Whether x [dimension] lies in the safe set where the obstacle is displaced by p, by more than rounding may have lost. False
// for NaN, and for other p.
inline bool safe(const double* x, const double* p) noexcept {{
  if (!displaced(p) || !in_workspace(x)) return false;
  const detail::Displaced at(x, p);
  return at.found && barrier(at.y) <= -(barrier_float64_error + displaced_barrier_error);
}}

)";

constexpr const char* kMoving =
    R"(// As velocity(x, p, v), where the obstacle is on its way with the velocity `rate` [displaced_places], in `unit` per second: with
// the true rate, x stays in the safe set as it moves.
inline bool velocity(const double* x, const double* p, const double* rate, double* v) noexcept {
  return detail::displaced_velocity(x, p, rate, v);
}

)";

// Of poses; the other signature would be mistaken for velocity(x, q, v, omega).
constexpr const char* kMovingPose =
    R"(// As velocity(x, p, v), where the obstacle is on its way with the velocity `rate` [displaced_places], in `unit` per second: with
// the true rate, x stays in the safe set as it moves. And omega [3], in rad/s, as in velocity(x, q, v, omega): the orientation
// q [4] follows as it would where the obstacle was, so the claim on it is the same.
inline bool velocity(const double* x, const double* q, const double* p, const double* rate, double* v, double* omega) noexcept {
  if (displaced(p)) {
    double before[dimension];
    velocity(detail::Displaced(x, p).y, q, before, omega);
  } else {
    for (int i = 0; i < 3; ++i) omega[i] = 0;
  }
  return detail::displaced_velocity(x, p, rate, v);
}

)";

}  // namespace

std::string displaced_source(const Policy& policy, const SceneRange& range) {
  const PolicyInfo& info = policy.info;
  const Displacement& displacement = range.displacement;
  const Eigen::Index places = displacement.places();
  const auto below = [](double value, double scale) { return (Interval(value) * scale).lower; };
  std::vector<double> box(static_cast<std::size_t>(places), HUGE_VAL);
  for (Eigen::Index i = 0; i < range.half_sizes.size(); ++i)
    box[static_cast<std::size_t>(i)] = below(range.half_sizes[i], info.position_scale);
  // Of a sum of squares there is no bound on all of R^n.
  const double steepness =
      is_sum_of_squares(policy.networks.B.head) ? HUGE_VAL : lipschitz_bound(policy.networks.B);
  return fmt::format(fmt::runtime(kDisplaced), places, number(below(range.radius, info.position_scale)),
                     numbers(box), numbers({displacement.center().begin(), displacement.center().end()}),
                     number(displacement.inner()), number(displacement.outer()),
                     number(below(range.margin, info.velocity_scale)),
                     number((Interval(steepness) * kInverseError).upper), number(Displacement::slope)) +
         (policy.orientation ? kMovingPose : kMoving);
}

}  // namespace s2nnds
