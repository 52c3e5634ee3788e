#include "s2nnds/sweeps/design.h"

#include <boost/random/sobol.hpp>

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

}  // namespace

std::vector<DesignPoint> make_design(const SweepOptions& options, const std::vector<Axis>& axes) {
  if (axes.empty()) return {DesignPoint{}};
  if (options.design == "grid") return grid(axes);
  return options.design == "random" ? random(options, axes) : sobol(options, axes);
}

}  // namespace s2nnds
