// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/backtrack.h"

#include <cmath>

#include "s2nnds/networks/evaluator.h"

namespace s2nnds {
namespace {

constexpr double kSpacing = 0.01;  // a motion passes an X0 smaller than this unseen

Points violating(const Networks& networks, const Points& counterexamples, const BacktrackOptions& options) {
  const BasicDynamicsEvaluator<float> dynamics(networks);
  const BasicEvaluator<float> B(networks.B);
  Points value, derivative;
  B.value_and_derivative(counterexamples, dynamics.value(counterexamples), value, derivative);
  std::vector<Eigen::Index> last;
  for (Eigen::Index i = counterexamples.rows() - 1; i >= 0; --i) {
    if (std::ssize(last) == options.motions) break;
    if (std::abs(value(i, 0)) < options.level_band && derivative(i, 0) >= 0.0) last.push_back(i);
  }
  return counterexamples(last, Eigen::all);
}

Points stacked(const std::vector<Points>& parts, Eigen::Index dimension) {
  Eigen::Index rows = 0;
  for (const Points& part : parts) rows += part.rows();
  Points all(rows, dimension);
  Eigen::Index at = 0;
  for (const Points& part : parts) {
    all.middleRows(at, part.rows()) = part;
    at += part.rows();
  }
  return all;
}

}  // namespace

std::vector<Points> motions_to(const Dynamics& dynamics, const Points& ends, const Box& within,
                               double spacing) {
  const BasicDynamicsEvaluator<float> field(dynamics);
  const auto direction = [&](const Points& x) {
    Points v = field.value(x);
    v.rowwise().normalize();  // leaves a zero as it is
    return v;
  };
  const auto steps = static_cast<Eigen::Index>(4.0 * within.half_widths().norm() / spacing);
  std::vector<Points> motions(ends.rows(), Points(steps + 1, ends.cols()));
  std::vector<Eigen::Index> going(ends.rows()), length(ends.rows(), 1);
  for (Eigen::Index i = 0; i < ends.rows(); ++i) {
    motions[i].row(0) = ends.row(i);
    going[i] = i;
  }
  Points x = ends;
  for (Eigen::Index k = 1; k <= steps && !going.empty(); ++k) {
    const Points half = x - 0.5 * spacing * direction(x);
    const Points before = x - spacing * direction(half);
    std::vector<Eigen::Index> rows, still;
    for (Eigen::Index i = 0; i < before.rows(); ++i) {
      if (!within.contains(before.row(i).transpose())) continue;  // nor where it is not a number
      rows.push_back(i);
      still.push_back(going[i]);
      motions[going[i]].row(k) = before.row(i);
      length[going[i]] = k + 1;
    }
    x = before(rows, Eigen::all);
    going = std::move(still);
  }
  for (std::size_t i = 0; i < motions.size(); ++i) motions[i].conservativeResize(length[i], Eigen::NoChange);
  return motions;
}

Backtracked backtrack(const Networks& networks, const SafetyProblem& problem, const Points& counterexamples,
                      const Points& position, const Points& velocity, const BacktrackOptions& options) {
  const Eigen::Index n = problem.dimension();
  std::vector<Points> from_initial, others;
  if (counterexamples.rows() > 0) {
    const Points ends = violating(networks, counterexamples, options);
    for (Points& motion : motions_to(networks.dynamics(), ends, problem.workspace, kSpacing)) {
      const bool passes_initial = problem.initial->level(motion).minCoeff() <= 0.0;
      (passes_initial ? from_initial : others).push_back(std::move(motion));
    }
  }
  Backtracked result;
  result.upstream = stacked(others, n);
  result.position = stacked(from_initial, n);
  result.velocity.resize(result.position.rows(), n);
  for (Eigen::Index i = 0; i < result.position.rows(); ++i) {
    Eigen::Index nearest = 0;
    (position.rowwise() - result.position.row(i)).rowwise().squaredNorm().minCoeff(&nearest);
    Eigen::RowVectorXd way = position.row(nearest) - result.position.row(i);
    if (problem.has_phase()) way[n - 1] = 0.0;  // a phase never rises
    result.velocity.row(i) = velocity.row(nearest) + options.gain * way;
  }
  return result;
}

}  // namespace s2nnds
