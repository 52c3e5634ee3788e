// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/design.h"

#include <boost/random/sobol.hpp>
#include <numeric>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

constexpr std::size_t most_points = 10'000'000;

std::vector<DesignPoint> grid(const std::vector<Axis>& axes) {
  std::vector<DesignPoint> points = {{}};
  for (const Axis& axis : axes) {
    const std::vector<std::string> values = axis.grid();
    check(points.size() * values.size() <= most_points, "axes: the grid has more than {} points",
          most_points);
    std::vector<DesignPoint> longer;
    longer.reserve(points.size() * values.size());
    for (const DesignPoint& point : points) {
      for (const std::string& value : values) {
        longer.push_back(point);
        longer.back().push_back(value);
      }
    }
    points = std::move(longer);
  }
  return points;
}

std::vector<DesignPoint> random(const SweepOptions& options, const std::vector<Axis>& axes) {
  std::vector<DesignPoint> points(options.points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    RandomStream stream(options.design_seed, "sweep", i);
    for (const Axis& axis : axes) points[i].push_back(axis.at(stream.uniform()));
  }
  return points;
}

std::vector<DesignPoint> sobol(const SweepOptions& options, const std::vector<Axis>& axes) {
  boost::random::sobol sequence(axes.size());
  RandomStream stream(options.design_seed, "sweep");
  std::vector<std::uint64_t> shifts(axes.size(), 0);
  for (std::uint64_t& shift : shifts) {
    if (options.design_seed != 0) shift = static_cast<std::uint64_t>(stream.uniform() * 0x1p53) << 11;
  }
  std::vector<DesignPoint> points(options.points);
  for (DesignPoint& point : points) {
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const std::uint64_t bits = static_cast<std::uint64_t>(sequence()) ^ shifts[k];
      point.push_back(axes[k].at(static_cast<double>(bits >> 11) * 0x1p-53));
    }
  }
  return points;
}

// Not std::shuffle, whose order differs from one standard library to the next.
void shuffle(std::vector<std::int64_t>& values, RandomStream random) {
  for (std::size_t k = values.size(); k > 1; --k) std::swap(values[k - 1], values[random.below(k)]);
}

}  // namespace

std::vector<DesignPoint> make_design(const SweepOptions& options, const std::vector<Axis>& axes) {
  if (options.design == "list") return std::vector<DesignPoint>(options.trials.size());
  if (axes.empty()) return {DesignPoint{}};
  if (options.design == "grid") return grid(axes);
  return options.design == "random" ? random(options, axes) : sobol(options, axes);
}

std::vector<std::int64_t> pairs_in_turn(std::size_t points, std::size_t pairs, std::uint64_t design_seed) {
  std::vector<std::int64_t> order(pairs), chosen(points);
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = 0; i < points; ++i) {
    if (i % pairs == 0) shuffle(order, RandomStream(design_seed, "sweep/pairs", i / pairs));
    chosen[i] = order[i % pairs];
  }
  return chosen;
}

}  // namespace s2nnds
