// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/ranking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "s2nnds/verification/certificate.h"

namespace s2nnds {
namespace {

double mean(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const bool positive = std::all_of(values.begin(), values.end(), [](double value) { return value > 0.0; });
  double sum = 0.0;
  for (const double value : values) sum += positive ? std::log(value) : value;
  sum /= static_cast<double>(values.size());
  return positive ? std::exp(sum) : sum;
}

PointScore score(const Sweep& sweep, std::int64_t point, const std::vector<const TrialResult*>& results) {
  PointScore score;
  score.point = point;
  score.trials = static_cast<std::int64_t>(results.size());
  std::vector<double> values;
  std::int64_t met = 0;
  for (const TrialResult* result : results) {
    score.failed += result->failed ? 1 : 0;
    if (result->failed) continue;
    met += counts(sweep.options, *result) ? 1 : 0;
    const double value = result->metric(sweep.options.objective);
    if (std::isfinite(value)) values.push_back(value);
  }
  score.share = static_cast<double>(met) / static_cast<double>(sweep.trials_a_point());
  score.feasible = score.share >= sweep.options.share && !values.empty();
  score.objective = mean(values);
  return score;
}

}  // namespace

bool counts(const SweepOptions& options, const TrialResult& result) {
  return !result.failed &&
         enum_from<Guarantee>(result.guarantee) >= enum_from<Guarantee>(options.guarantee) &&
         (options.dtw_limit == 0.0 || result.metric("dtw_train") <= options.dtw_limit);
}

std::vector<PointScore> rank_points(const Sweep& sweep, const std::vector<TrialResult>& results) {
  std::map<std::int64_t, std::vector<const TrialResult*>> by_point;
  for (const TrialResult& result : results) by_point[sweep.trial(result.trial).point].push_back(&result);
  std::vector<PointScore> ranking;
  for (const auto& [point, of_point] : by_point) ranking.push_back(score(sweep, point, of_point));
  const double sign = sweep.options.direction == "maximize" ? -1.0 : 1.0;
  const auto badness = [&](const PointScore& s) {
    return std::isfinite(s.objective) ? sign * s.objective : std::numeric_limits<double>::infinity();
  };
  std::stable_sort(ranking.begin(), ranking.end(), [&](const PointScore& a, const PointScore& b) {
    if (a.feasible != b.feasible) return a.feasible;
    if (!a.feasible && a.share != b.share) return a.share > b.share;
    return badness(a) < badness(b);
  });
  return ranking;
}

std::vector<std::int64_t> promoted(const HalvingOptions& options, const std::vector<PointScore>& ranking) {
  const auto kept = static_cast<std::size_t>(
      std::max(1.0, std::ceil(options.keep * static_cast<double>(ranking.size()) - 1e-9)));
  std::vector<std::int64_t> points;
  for (std::size_t i = 0; i < std::min(kept, ranking.size()); ++i) points.push_back(ranking[i].point);
  std::sort(points.begin(), points.end());
  return points;
}

}  // namespace s2nnds
