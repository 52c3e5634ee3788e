#include "s2nnds/training/level.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/parallel.h"
#include "s2nnds/networks/evaluator.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kRowsTogether = 1024;

// In single precision, which is enough for a proposal.
struct BarrierValues {
  Vector value, derivative;
};

BarrierValues along_motion(const Networks& networks, const Points& x) {
  const BasicEvaluator<float> f(networks.f), B(networks.B);
  BarrierValues found{Vector(x.rows()), Vector(x.rows())};
  parallel_for((x.rows() + kRowsTogether - 1) / kRowsTogether, [&](Eigen::Index part, int) {
    const Eigen::Index first = part * kRowsTogether, rows = std::min(kRowsTogether, x.rows() - first);
    const Points at = x.middleRows(first, rows);
    Points value, derivative;
    B.value_and_derivative(at, f.value(at), value, derivative);
    found.value.segment(first, rows) = value.col(0);
    found.derivative.segment(first, rows) = derivative.col(0);
  });
  return found;
}

// From `high` down, the first c that is no nearer than `distance` to any of the values.
double highest_free(double high, double distance, std::vector<double> values) {
  std::sort(values.begin(), values.end(), std::greater<>());
  double c = high;
  for (const double value : values) {
    if (value > c + distance) continue;
    if (value < c - distance) break;
    c = value - distance;
  }
  return c;
}

}  // namespace

LevelChoice::LevelChoice(const SafetyProblem& problem, const LevelOptions& options)
    : problem_(problem), options_(options) {
  RegionSampler initial(problem.initial, problem.workspace);
  if (!initial.empty()) initial_ = std::move(initial);
  for (const RegionPtr& region : {problem.unsafe, problem.shell}) {
    if (!region) continue;
    RegionSampler sampler(region, problem.workspace);
    if (!sampler.empty()) outside_.push_back(std::move(sampler));
  }
}

std::optional<double> LevelChoice::largest(const Networks& networks, RandomStream& random) const {
  const std::int64_t in_region = std::max<std::int64_t>(1, options_.samples * 2 / 5);
  const BasicEvaluator<float> B(networks.B);
  double low = -options_.reach, high = options_.reach;
  if (initial_) low = std::max(low, B.value(initial_->sample(in_region, random)).maxCoeff() + options_.slack);
  for (const RegionSampler& sampler : outside_)
    high = std::min(high, B.value(sampler.sample(in_region, random)).minCoeff() - options_.slack);
  if (!(low <= high)) return std::nullopt;

  Points x(options_.samples, problem_.dimension());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    for (Eigen::Index k = 0; k < x.cols(); ++k)
      x(i, k) = random.uniform(problem_.workspace.lower[k], problem_.workspace.upper[k]);
  }
  const BarrierValues at = along_motion(networks, x);
  std::vector<double> forbidden;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    if (!(at.derivative[i] <= -options_.slack_decrease)) forbidden.push_back(at.value[i]);
  }
  const double c = highest_free(high, 1.5 * options_.band, std::move(forbidden));
  if (!(low <= c)) return std::nullopt;
  return c;
}

}  // namespace s2nnds
