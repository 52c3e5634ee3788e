#include "s2nnds/sweeps/effects.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "s2nnds/sweeps/ranking.h"

namespace s2nnds {
namespace {

using Matrix = Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// One column of the model: a range's position in [0, 1], or whether a list has the value.
struct Term {
  std::size_t axis = 0;
  std::string from, to;
  double at(const Axis& of_it, const std::string& value) const {
    if (!of_it.values.empty()) return value == to ? 1.0 : 0.0;
    const auto scaled = [&](double x) { return of_it.logarithmic ? std::log(x) : x; };
    return (scaled(std::stod(value)) - scaled(of_it.low)) / (scaled(of_it.high) - scaled(of_it.low));
  }
};

std::vector<Term> terms_of(const std::vector<Axis>& axes) {
  std::vector<Term> terms;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const std::vector<std::string> values = axes[k].extremes();
    for (std::size_t i = 1; i < values.size(); ++i) terms.push_back({k, values.front(), values[i]});
  }
  return terms;
}

struct Observation {
  Trial trial;
  double value = 0.0;
};

// Each effect of the model, or none if the observations do not tell them apart or are all the same.
std::vector<Effect> fit(const Sweep& sweep, const std::vector<Term>& terms,
                        const std::vector<Observation>& observations) {
  std::map<std::int64_t, Eigen::Index> problems;
  for (const Observation& o : observations) problems.emplace(o.trial.config, problems.size());
  const auto rows = static_cast<Eigen::Index>(observations.size()),
             effects = static_cast<Eigen::Index>(terms.size()),
             columns = effects + static_cast<Eigen::Index>(problems.size());
  const auto [least, most] =
      std::minmax_element(observations.begin(), observations.end(),
                          [](const Observation& a, const Observation& b) { return a.value < b.value; });
  if (rows <= columns || least->value == most->value) return {};
  Matrix model = Matrix::Zero(rows, columns);
  VectorXd value(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Observation& o = observations[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < effects; ++k) {
      const Term& term = terms[static_cast<std::size_t>(k)];
      model(i, k) = term.at(sweep.axes[term.axis], sweep.points[o.trial.point][term.axis]);
    }
    model(i, effects + problems.at(o.trial.config)) = 1.0;
    value[i] = o.value;
  }
  const Eigen::ColPivHouseholderQR<Matrix> solver(model);
  if (solver.rank() < columns) return {};
  const VectorXd solution = solver.solve(value);
  const double variance = (value - model * solution).squaredNorm() / static_cast<double>(rows - columns);
  // With model P = Q R, the inverse of model' model is root root' with root = P R^-1: its diagonal cannot
  // become negative.
  const Matrix root = solver.colsPermutation() * Matrix(solver.matrixR()
                                                            .topLeftCorner(columns, columns)
                                                            .triangularView<Eigen::Upper>()
                                                            .solve(Matrix::Identity(columns, columns)));
  // What is the same in all trials of each problem leaves rounding behind, which is no effect.
  const double rounding = 1e-12 * value.cwiseAbs().maxCoeff();
  const auto rounded = [&](double x) { return std::abs(x) < rounding ? 0.0 : x; };
  std::vector<Effect> found;
  for (Eigen::Index k = 0; k < effects; ++k)
    found.push_back({rounded(solution[k]), rounded(std::sqrt(variance) * root.row(k).norm())});
  return found;
}

// Those of a rung's trials in which the figure was measured.
std::vector<Observation> observe(const Sweep& sweep, const std::string& figure,
                                 const std::vector<TrialResult>& results) {
  std::vector<Observation> observations;
  for (const TrialResult& result : results) {
    const bool counting = counts(sweep.options, result);
    double value = counting ? 1.0 : 0.0;
    if (figure != "counts") {
      if (!counting) continue;
      value = figure == "seconds" ? result.seconds : result.metric(figure);
    }
    if (std::isfinite(value)) observations.push_back({sweep.trial(result.trial), value});
  }
  return observations;
}

}  // namespace

EffectTable estimate_effects(const Sweep& sweep, const std::vector<TrialResult>& results) {
  EffectTable table;
  const std::vector<Term> terms = terms_of(sweep.axes);
  for (const Term& term : terms) table.rows.push_back({sweep.axes[term.axis].key, term.from, term.to, {}});
  std::vector<std::string> names = {sweep.options.objective, "counts"};
  for (const char* more : {"safe_area_ratio", "seconds"}) {
    if (sweep.options.objective != more) names.push_back(more);
  }
  for (const std::string& name : names) {
    std::vector<Observation> observations = observe(sweep, name, results);
    EffectFigure figure{.name = name, .trials = static_cast<std::int64_t>(observations.size())};
    figure.factor = name != "counts" && name != "safe_area_ratio" &&
                    std::all_of(observations.begin(), observations.end(),
                                [](const Observation& o) { return o.value > 0.0; });
    if (figure.factor) {
      for (Observation& o : observations) o.value = std::log(o.value);
    }
    const std::vector<Effect> effects = fit(sweep, terms, observations);
    figure.told = !effects.empty();
    for (std::size_t k = 0; k < terms.size(); ++k) {
      Effect effect = figure.told ? effects[k] : Effect{kUnknown, kUnknown};
      if (figure.factor) effect = {std::exp(effect.change), std::exp(effect.change) * effect.error};
      table.rows[k].on.push_back(effect);
    }
    table.figures.push_back(std::move(figure));
  }
  return table;
}

}  // namespace s2nnds
