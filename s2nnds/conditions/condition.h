// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string_view>

#include "s2nnds/conditions/execution_model.h"
#include "s2nnds/core/enum_names.h"
#include "s2nnds/networks/network_weights.h"
#include "s2nnds/problem/safety_problem.h"

namespace s2nnds {

// What must hold, defined once for losses, sampling, conformal calibration and proof. Each condition has a
// residual rho(x) (the paper's rho_q) where it applies; rho <= 0 is good, and for strict conditions rho = 0
// is a violation.
enum class Condition {
  lyapunov_positive,  // rho_1 = -V     < 0   on X without the goal
  lyapunov_decrease,  // rho_2 = Vdot   < 0   on X without the goal, Vdot = grad V . f
  initial,            // rho_3 = B     <= 0   on X0
  unsafe,             // rho_4 = -B     < 0   on Xu
  containment,        // rho_4 = -B     < 0   on the workspace's outer margin
  barrier_decrease,   // rho_5 = Bdot   < 0   where |B| <= level_band, Bdot = grad B . f
};
// In the order of the columns of residuals().
inline constexpr std::array<Condition, 6> all_conditions = {
    Condition::lyapunov_positive, Condition::lyapunov_decrease, Condition::initial, Condition::unsafe,
    Condition::containment,       Condition::barrier_decrease};
inline constexpr Eigen::Index condition_count = all_conditions.size();  // columns of residuals()

template <>
struct EnumNames<Condition> {
  static constexpr std::string_view what = "condition";
  static constexpr auto names = std::to_array<std::string_view>(
      {"lyapunov_positive", "lyapunov_decrease", "initial", "unsafe", "containment", "barrier_decrease"});
};

// Whether rho <= 0 suffices; otherwise rho < 0 is needed.
bool allows_zero(Condition condition);

// Whether `residual` = rho(x) breaks the condition; NaN does.
inline bool is_violated(Condition condition, double residual) {
  return allows_zero(condition) ? !(residual <= 0.0) : !(residual < 0.0);
}

// Of the networks' arithmetic. Single precision is for searching: a residual near 0 may have the wrong sign.
enum class Precision { single_, double_ };

// The residuals at N points [N, n] -> [N, condition_count]; -infinity where a condition does not apply, NaN
// where a network overflows. `level_band` is eps_B, the half-width of the band around {B = 0}. Nothing
// applies outside X; a point at the goal itself (x = 0 exactly) is outside rho_1 and rho_2.
// With a `demand`, rho_5 and, beyond its radius, rho_2 are the rates along the worst motion that the
// execution model admits (worst_perturbation.h) instead of those along f.
Points residuals(const Networks& networks, const SafetyProblem& problem, double level_band, const Points& x,
                 Precision precision = Precision::double_, const ExecutionDemand& demand = {});

// One column of `residuals` [N], evaluating only the networks that it needs.
Vector residual(Condition condition, const Networks& networks, const SafetyProblem& problem,
                double level_band, const Points& x);

}  // namespace s2nnds
