// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/topology.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "s2nnds/problem/cell_grid.h"

namespace s2nnds {
namespace {

constexpr std::size_t kLeastCells = 3;   // of an island that is reported
constexpr double kGoalRadius = 0.03;     // equilibria so near to the goal are the goal, or its grid error
constexpr std::size_t kMostStarts = 60;  // of Newton's method
constexpr int kNewtonSteps = 30;
constexpr double kStep = 1e-5;       // of the differences that stand for derivatives
constexpr double kConverged = 1e-9;  // |f| at an equilibrium

std::vector<Island> find_islands(const CellGrid& grid, const Points& middles, const Points& barrier,
                                 const SafetyProblem& problem) {
  std::vector<bool> outside(middles.rows()), reached(middles.rows(), false);
  std::vector<Eigen::Index> edge;
  for (Eigen::Index k = 0; k < middles.rows(); ++k) {
    outside[k] = barrier(k, 0) > 0.0;
    if (outside[k] && grid.is_at_edge(k)) edge.push_back(k);
  }
  flood(grid, outside, std::move(edge), reached);
  std::vector<Island> islands;
  const Vector unsafe = problem.unsafe->level(middles);
  for (Eigen::Index k = 0; k < middles.rows(); ++k) {
    if (!outside[k] || reached[k]) continue;
    std::vector<bool> part(middles.rows(), false);
    flood(grid, outside, {k}, part);
    std::size_t cells = 0;
    bool holds_obstacle = false;
    for (Eigen::Index j = k; j < middles.rows(); ++j) {
      if (!part[j]) continue;
      ++cells;
      reached[j] = true;
      holds_obstacle = holds_obstacle || unsafe[j] <= 0.0;
    }
    if (cells < kLeastCells) continue;
    islands.push_back(
        {middles.row(k).transpose(), static_cast<double>(cells) * grid.cell_volume(), holds_obstacle});
  }
  std::stable_sort(islands.begin(), islands.end(),
                   [](const Island& a, const Island& b) { return a.volume > b.volume; });
  return islands;
}

// Cells next to one of {B <= 0} count as free, which bridges straits that the grid misses.
std::vector<Fragment> find_fragments(const CellGrid& grid, const Points& middles, const Points& barrier) {
  const Eigen::Index n = middles.cols(), size = middles.rows();
  std::vector<bool> free(size), reached(size, false);
  for (Eigen::Index k = 0; k < size; ++k) {
    free[k] = barrier(k, 0) <= 0.0;
    grid.neighbours(k, [&](Eigen::Index next) { free[k] = free[k] || barrier(next, 0) <= 0.0; });
  }
  flood(grid, free, {grid.cell_of(Vector::Zero(n))}, reached);
  std::vector<Fragment> fragments;
  for (Eigen::Index k = 0; k < size; ++k) {
    if (reached[k] || barrier(k, 0) > 0.0) continue;
    std::vector<bool> part(size, false);
    flood(grid, free, {k}, part);
    std::size_t cells = 0;
    for (Eigen::Index j = 0; j < size; ++j) {
      if (!part[j]) continue;
      reached[j] = true;
      if (barrier(j, 0) <= 0.0) ++cells;
    }
    if (cells >= kLeastCells)
      fragments.push_back({middles.row(k).transpose(), static_cast<double>(cells) * grid.cell_volume()});
  }
  std::stable_sort(fragments.begin(), fragments.end(),
                   [](const Fragment& a, const Fragment& b) { return a.volume > b.volume; });
  return fragments;
}

Eigen::MatrixXd jacobian(const StateFunction& f, const Vector& x) {
  const Eigen::Index n = x.size();
  Points around(2 * n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    around.row(2 * k) = around.row(2 * k + 1) = x.transpose();
    around(2 * k, k) += kStep;
    around(2 * k + 1, k) -= kStep;
  }
  const Points value = f.value(around);
  Eigen::MatrixXd J(n, n);
  for (Eigen::Index k = 0; k < n; ++k)
    J.col(k) = (value.row(2 * k) - value.row(2 * k + 1)).transpose() / (2.0 * kStep);
  return J;
}

Vector at(const StateFunction& f, const Vector& x) { return f.value(x.transpose()).row(0).transpose(); }

// Newton's method with halved steps, while |f| falls and the place stays in the workspace.
std::optional<Vector> solve(const StateFunction& f, Vector x, const Box& within) {
  Vector value = at(f, x);
  for (int k = 0; k < kNewtonSteps && !(value.norm() < kConverged); ++k) {
    const Vector step = jacobian(f, x).fullPivLu().solve(value);
    if (!step.allFinite()) return std::nullopt;
    bool fell = false;
    for (double part = 1.0; part > 1e-3 && !fell; part *= 0.5) {
      const Vector next = x - part * step;
      if (!within.contains(next)) continue;
      const Vector there = at(f, next);
      fell = there.norm() < value.norm();
      if (fell) x = next, value = there;
    }
    if (!fell) break;
  }
  if (!(value.norm() < kConverged)) return std::nullopt;
  return x;
}

std::vector<Equilibrium> find_equilibria(const StateFunction& f, const CellGrid& grid, const Points& middles,
                                         const SafetyProblem& problem) {
  const Vector speed = f.quick_value(middles).rowwise().norm();
  std::vector<Eigen::Index> lowest;
  for (Eigen::Index k = 0; k < middles.rows(); ++k) {
    bool least = middles.row(k).norm() > kGoalRadius;
    grid.neighbours(k, [&](Eigen::Index next) { least = least && speed[k] <= speed[next]; });
    if (least) lowest.push_back(k);
  }
  std::stable_sort(lowest.begin(), lowest.end(), [&](auto a, auto b) { return speed[a] < speed[b]; });
  lowest.resize(std::min(lowest.size(), kMostStarts));
  std::vector<Equilibrium> found;
  for (const Eigen::Index k : lowest) {
    const auto x = solve(f, middles.row(k).transpose(), problem.workspace);
    if (!x || x->norm() < kGoalRadius) continue;
    if (std::any_of(found.begin(), found.end(),
                    [&](const Equilibrium& old) { return (old.place - *x).norm() < 1e-3; }))
      continue;
    const double determinant = jacobian(f, *x).determinant();
    const std::int64_t index = determinant > 1e-6 ? 1 : determinant < -1e-6 ? -1 : 0;
    found.push_back({*x, index, problem.unsafe->level(x->transpose())[0] <= 0.0});
  }
  return found;
}

}  // namespace

Topology find_topology(const StateFunction& f, const StateFunction& B, const SafetyProblem& problem) {
  if (problem.dimension() > 3) return {};
  const CellGrid grid(problem.workspace, problem.dimension() == 2 ? 121 : 41);
  const Points middles = grid.middles();
  const Points barrier = B.quick_value(middles);
  return {find_islands(grid, middles, barrier, problem),
          problem.dimension() == 2 ? find_fragments(grid, middles, barrier) : std::vector<Fragment>(),
          find_equilibria(f, grid, middles, problem)};
}

}  // namespace s2nnds
