// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/conditions/condition.h"

#include <cmath>
#include <limits>

#include "s2nnds/conditions/worst_perturbation.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/networks/dynamics.h"

namespace s2nnds {
namespace {

constexpr double kDoesNotApply = -std::numeric_limits<double>::infinity();
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

using Mask = Eigen::Array<bool, Eigen::Dynamic, 1>;

// Negated comparisons: a NaN coordinate counts as inside, so that it ends as a violation and not as "does not
// apply".
Mask within(const Box& box, const Points& x) {
  Mask inside(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    inside[i] = true;
    for (Eigen::Index k = 0; k < x.cols(); ++k) {
      inside[i] = inside[i] && !(x(i, k) < box.lower[k]) && !(x(i, k) > box.upper[k]);
    }
  }
  return inside;
}

Mask within(const RegionPtr& region, const Points& x) {
  if (!region) return Mask::Constant(x.rows(), false);
  return region->level(x).array() <= 0.0;
}

Mask is_goal(const Points& x) { return (x.array() == 0.0).rowwise().all(); }

// A barrier without a finite value is not known to be off the band.
Mask within_band(const Vector& barrier, double level_band) {
  const auto magnitude = barrier.array().abs();
  return !(magnitude > level_band && magnitude < std::numeric_limits<double>::infinity());
}

// What the conditions are made of, for a set of points.
struct Ingredients {
  Vector lyapunov, lyapunov_derivative, barrier, barrier_derivative;  // V, Vdot, B, Bdot: each [N], or empty
};

constexpr Eigen::Index kRowsTogether = 1024;  // so that what passes from network to network stays in cache

// Adds to the rates at the rows where it `counts` what the model does there at worst.
template <typename T, typename Counts>
void add_work(const ExecutionModel& model, const BasicEvaluator<T>& function, const BasicEvaluator<T>& f,
              const Points& at, const Points& velocity, const Counts& counts, Eigen::Ref<Vector> rate) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < at.rows(); ++i) {
    if (counts(i)) rows.push_back(i);
  }
  if (rows.empty()) return;
  rate(rows) += perturbation_work<T>(model, function, f, at(rows, Eigen::all), velocity(rows, Eigen::all));
}

template <typename T>
Ingredients evaluate_all(const Networks& networks, double level_band, const Points& x,
                         const ExecutionDemand& demand) {
  const BasicDynamicsEvaluator<T> dynamics(networks);
  const BasicEvaluator<T> f(networks.f), V(networks.V), B(networks.B);
  Ingredients found;
  for (Vector* column :
       {&found.lyapunov, &found.lyapunov_derivative, &found.barrier, &found.barrier_derivative})
    column->resize(x.rows());
  parallel_for((x.rows() + kRowsTogether - 1) / kRowsTogether, [&](Eigen::Index part, int) {
    const Eigen::Index first = part * kRowsTogether, rows = std::min(kRowsTogether, x.rows() - first);
    const Points at = x.middleRows(first, rows), velocity = dynamics.value(at);
    Points value, derivative;
    V.value_and_derivative(at, velocity, value, derivative);
    found.lyapunov.segment(first, rows) = value.col(0);
    found.lyapunov_derivative.segment(first, rows) = derivative.col(0);
    if (demand.asks_of_lyapunov()) {
      add_work(
          demand.model, V, f, at, velocity,
          [&](Eigen::Index i) { return !(at.row(i).norm() <= demand.convergence_radius); },
          found.lyapunov_derivative.segment(first, rows));
    }
    B.value_and_derivative(at, velocity, value, derivative);
    found.barrier.segment(first, rows) = value.col(0);
    found.barrier_derivative.segment(first, rows) = derivative.col(0);
    if (demand.asks_of_barrier()) {
      const Mask near = within_band(value.col(0), level_band);
      add_work(
          demand.model, B, f, at, velocity, [&](Eigen::Index i) { return near[i]; },
          found.barrier_derivative.segment(first, rows));
    }
  });
  return found;
}

Ingredients evaluate_for(Condition condition, const Networks& networks, const Points& x) {
  Points value, derivative;
  Ingredients found;
  switch (condition) {
    case Condition::lyapunov_positive:
      found.lyapunov = networks.V.value(x).col(0);
      break;
    case Condition::lyapunov_decrease:
      networks.V.value_and_derivative(x, networks.velocity(x), value, derivative);
      found.lyapunov_derivative = derivative.col(0);
      break;
    case Condition::initial:
    case Condition::unsafe:
    case Condition::containment:
      found.barrier = networks.B.value(x).col(0);
      break;
    case Condition::barrier_decrease:
      networks.B.value_and_derivative(x, networks.velocity(x), value, derivative);
      found.barrier = value.col(0);
      found.barrier_derivative = derivative.col(0);
      break;
  }
  return found;
}

// A network that overflows has no value there: that is a violation, and must not look like "does not apply".
Vector keep_where(const Mask& applies, const Vector& residual) {
  Vector kept = Vector::Constant(residual.size(), kDoesNotApply);
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    if (applies[i]) kept[i] = std::isfinite(residual[i]) ? residual[i] : kNotANumber;
  }
  return kept;
}

// rho_q where it applies; `inside` says which points lie in X.
Vector residual_of(Condition condition, const Ingredients& at, const SafetyProblem& problem,
                   double level_band, const Mask& inside, const Points& x) {
  switch (condition) {
    case Condition::lyapunov_positive:
      return keep_where(inside && !is_goal(x), -at.lyapunov);
    case Condition::lyapunov_decrease:
      return keep_where(inside && !is_goal(x), at.lyapunov_derivative);
    case Condition::initial:
      return keep_where(inside && within(problem.initial, x), at.barrier);
    case Condition::unsafe:
      return keep_where(inside && within(problem.unsafe, x), -at.barrier);
    case Condition::containment:
      return keep_where(inside && within(problem.workspace_margin, x), -at.barrier);
    case Condition::barrier_decrease:
      return keep_where(inside && within_band(at.barrier, level_band), at.barrier_derivative);
  }
  fail("condition: found the value {}, expected 0 to {}", static_cast<int>(condition), condition_count - 1);
}

void check_points(const SafetyProblem& problem, double level_band, const Points& x) {
  check(x.cols() == problem.dimension(), "residuals: found points of dimension {}, expected {}", x.cols(),
        problem.dimension());
  check(level_band >= 0.0, "residuals: found level_band = {}, expected >= 0", level_band);
}

}  // namespace

bool allows_zero(Condition condition) { return condition == Condition::initial; }

Points residuals(const Networks& networks, const SafetyProblem& problem, double level_band, const Points& x,
                 Precision precision, const ExecutionDemand& demand) {
  check_points(problem, level_band, x);
  const Ingredients at = precision == Precision::single_
                             ? evaluate_all<float>(networks, level_band, x, demand)
                             : evaluate_all<double>(networks, level_band, x, demand);
  const Mask inside = within(problem.workspace, x);
  Points all(x.rows(), condition_count);
  for (std::size_t i = 0; i < all_conditions.size(); ++i) {
    all.col(static_cast<Eigen::Index>(i)) =
        residual_of(all_conditions[i], at, problem, level_band, inside, x);
  }
  return all;
}

Vector residual(Condition condition, const Networks& networks, const SafetyProblem& problem,
                double level_band, const Points& x) {
  check_points(problem, level_band, x);
  return residual_of(condition, evaluate_for(condition, networks, x), problem, level_band,
                     within(problem.workspace, x), x);
}

}  // namespace s2nnds
