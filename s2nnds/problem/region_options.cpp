// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <filesystem>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {
namespace {

Vector vector(const std::vector<double>& numbers, const char* key, Eigen::Index dimension,
              const std::string& where) {
  check(static_cast<Eigen::Index>(numbers.size()) == dimension, "{}: {} has {} numbers, expected {}", where,
        key, numbers.size(), dimension);
  return Eigen::Map<const Vector>(numbers.data(), dimension);
}

RegionPtr make_polynomial(const RegionOptions& options, Eigen::Index dimension, const std::string& data_dir) {
  check(options.level.empty() != options.file.empty(), "polynomial: expected one of the keys level and file");
  check(options.sign == 1.0 || options.sign == -1.0, "polynomial: sign is {}, expected 1 or -1",
        options.sign);
  if (!options.level.empty()) {
    return polynomial(Polynomial::from_text(options.level, dimension) * options.sign,
                      options.sign > 0.0 ? options.level : fmt::format("-({})", options.level));
  }
  const std::string path = (std::filesystem::path(data_dir) / options.file).string();
  return polynomial(Polynomial::from_json_file(path, dimension) * options.sign,
                    fmt::format("{}polynomial of {}", options.sign > 0.0 ? "" : "-", options.file));
}

std::vector<RegionPtr> make_all(const RegionOptions& options, Eigen::Index dimension,
                                const std::string& data_dir) {
  std::vector<RegionPtr> regions;
  for (std::size_t i = 0; i < options.of.size(); ++i) {
    regions.push_back(make_region(options.of[i], dimension, data_dir, fmt::format("of[{}]", i)));
  }
  return regions;
}

RegionPtr make(const RegionOptions& options, Eigen::Index dimension, const std::string& data_dir) {
  const std::string& type = options.type;
  const auto numbers = [&](const std::vector<double>& value, const char* key) {
    return vector(value, key, dimension, type);
  };
  if (type == "none") return empty_region(dimension);
  if (type == "ball") return ball(numbers(options.center, "center"), options.radius);
  if (type == "box") return box_region({numbers(options.lower, "lower"), numbers(options.upper, "upper")});
  if (type == "ellipsoid") {
    return ellipsoid(numbers(options.center, "center"), numbers(options.semi_axes, "semi_axes"));
  }
  if (type == "halfspace") return halfspace(numbers(options.normal, "normal"), options.offset);
  if (type == "expression") return expression(options.level, dimension);
  if (type == "polynomial") return make_polynomial(options, dimension, data_dir);
  if (type == "union") return unite(make_all(options, dimension, data_dir));
  if (type == "intersection") return intersect(make_all(options, dimension, data_dir));
  if (type == "complement") {
    check(options.of.size() == 1, "complement: of has {} regions, expected 1", options.of.size());
    return complement(make_all(options, dimension, data_dir).front());
  }
  fail("type '{}' cannot be used here, expected a set such as ball, box or expression", type);
}

}  // namespace

void RegionOptions::visit(FieldVisitor& v) {
  v.field("type", type,
          {"none", "ball", "box", "ellipsoid", "polynomial", "halfspace", "expression", "union",
           "intersection", "complement", "auto", "ball_auto"});
  if (type == "ball" || type == "ellipsoid") v.field("center", center, any_number());
  if (type == "ball" || type == "ball_auto") v.field("radius", radius, above(0.0));
  if (type == "ellipsoid") v.field("semi_axes", semi_axes, above(0.0));
  if (type == "box") {
    v.field("lower", lower, any_number());
    v.field("upper", upper, any_number());
  }
  if (type == "halfspace") {
    v.field("normal", normal, any_number());
    v.field("offset", offset, any_number());
  }
  if (type == "expression" || type == "polynomial") v.field("level", level);
  if (type == "polynomial") {
    v.field("file", file);
    v.field("sign", sign, between(-1.0, 1.0));
  }
  if (type == "union" || type == "intersection" || type == "complement") v.list("of", of);
}

RegionPtr make_region(const RegionOptions& options, Eigen::Index dimension, const std::string& data_dir,
                      const std::string& where) {
  check(dimension > 0, "{}: dimension {}, expected at least 1", where, dimension);
  try {
    return make(options, dimension, data_dir);
  } catch (const Error& error) {
    fail("{}: {}", where, error.what());
  }
}

}  // namespace s2nnds
