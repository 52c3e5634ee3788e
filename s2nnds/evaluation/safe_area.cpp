// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/safe_area.h"

#include <algorithm>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <cstdint>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kLargestGridDimension = 3;
constexpr double kMostPoints = 1e8;  // 2.4 GB of 3-D points; more is a slip of the keyboard

int default_cells(Eigen::Index dimension) {
  if (dimension <= 2) return 200;
  return dimension == 3 ? 40 : 40000;
}

// Cell centres of a grid with `cells` along each side, the last axis running fastest.
Points grid_points(const Box& within, int cells) {
  const Eigen::Index n = within.dimension();
  const double wanted = std::pow(cells, static_cast<double>(n));
  check(wanted <= kMostPoints, "area: found {} cells a side in {}-D, expected at most {:g} cells in all",
        cells, n, kMostPoints);
  Points x(static_cast<Eigen::Index>(std::llround(wanted)), n);
  const Vector side = (within.upper - within.lower) / cells;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    Eigen::Index rest = i;
    for (Eigen::Index k = n - 1; k >= 0; --k) {
      x(i, k) = within.lower[k] + (static_cast<double>(rest % cells) + 0.5) * side[k];
      rest /= cells;
    }
  }
  return x;
}

Points sobol_points(const Box& within, int count) {
  boost::random::sobol sequence(static_cast<std::size_t>(within.dimension()));
  const double scale = std::ldexp(1.0, -64);
  Points x(count, within.dimension());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    for (Eigen::Index k = 0; k < x.cols(); ++k) {
      const double unit = static_cast<double>(sequence()) * scale;
      x(i, k) = within.lower[k] + (within.upper[k] - within.lower[k]) * unit;
    }
  }
  return x;
}

// The box without the phase.
Box places_of(const SafetyProblem& problem) {
  return {problem.workspace.lower.head(problem.places()), problem.workspace.upper.head(problem.places())};
}

// Places as states: a phase is where it starts.
Points states_at(const Points& places, const SafetyProblem& problem) {
  if (!problem.has_phase()) return places;
  Points states(places.rows(), problem.dimension());
  states << places, Vector::Constant(places.rows(), problem.phase_start);
  return states;
}

// How many of the points have B <= 0.
Eigen::Index count_inside(const StateFunction& B, const Points& x) {
  check_outputs(B, x.row(0), 1, "area");
  return (B.value(x).array() <= 0.0).count();
}

double area_of(Eigen::Index hits, Eigen::Index points, const Box& within) {
  return within.volume() * static_cast<double>(hits) / static_cast<double>(points);
}

}  // namespace

Points evaluation_points(const Box& within, int cells) {
  check(cells > 0, "area: found cells = {}, expected > 0", cells);
  check(within.lower.allFinite() && within.upper.allFinite(),
        "area: found an infinite box, expected a finite one");
  const bool grid = within.dimension() <= kLargestGridDimension;
  return grid ? grid_points(within, cells) : sobol_points(within, cells);
}

SafeArea measure_safe_area(const StateFunction& f, const StateFunction& B, const SafetyProblem& problem,
                           int cells, const BatchRolloutOptions& options) {
  check(cells >= 0, "area: found cells = {}, expected >= 0", cells);
  const Box places = places_of(problem);
  const Points x =
      states_at(evaluation_points(places, cells > 0 ? cells : default_cells(problem.places())), problem);
  const std::vector<bool> safe = rollout_is_safe(f, problem, x, options);
  return {.safe_area = area_of(count_inside(B, x), x.rows(), places),
          .true_safe_area = area_of(std::count(safe.begin(), safe.end(), true), x.rows(), places)};
}

double sublevel_area(const StateFunction& B, const Box& within, int cells) {
  const Points x = evaluation_points(within, cells);
  return area_of(count_inside(B, x), x.rows(), within);
}

}  // namespace s2nnds
