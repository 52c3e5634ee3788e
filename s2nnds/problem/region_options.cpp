// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/ranges.h>

#include <cmath>
#include <functional>
#include <map>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/arm_region.h"
#include "s2nnds/problem/extruded_region.h"
#include "s2nnds/problem/inflated_region.h"
#include "s2nnds/problem/mesh_file.h"
#include "s2nnds/problem/occupancy_region.h"
#include "s2nnds/problem/placed_region.h"
#include "s2nnds/problem/point_cloud_file.h"
#include "s2nnds/problem/polygon.h"
#include "s2nnds/problem/polytope.h"
#include "s2nnds/problem/region.h"
#include "s2nnds/problem/surface_region.h"
#include "s2nnds/problem/tube.h"

namespace s2nnds {
namespace {

// What a region is made from.
struct Making {
  const RegionOptions& options;
  Eigen::Index dimension;
  RegionFiles& files;

  // The numbers of a key as a point [n].
  Vector point(const std::vector<double>& numbers, const char* key) const {
    check(static_cast<Eigen::Index>(numbers.size()) == dimension, "{}: {} has {} numbers, expected {}",
          options.type, key, numbers.size(), dimension);
    return Eigen::Map<const Vector>(numbers.data(), dimension);
  }
  // The rows of a key as points [N, n].
  Points points(const std::vector<std::vector<double>>& rows, const char* key) const {
    Points result(static_cast<Eigen::Index>(rows.size()), dimension);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      result.row(static_cast<Eigen::Index>(k)) =
          point(rows[k], fmt::format("{}[{}]", key, k).c_str()).transpose();
    }
    return result;
  }
  Rotation rotation() const {
    check(dimension == 2 || options.angle == 0.0,
          "{}: found an angle in {} dimensions, expected the key rotation", options.type, dimension);
    check(dimension == 3 || options.rotation.empty(),
          "{}: found a rotation in {} dimensions, expected it in 3", options.type, dimension);
    if (dimension == 2) return options.angle == 0.0 ? no_rotation(2) : rotation_by_angle(options.angle);
    if (options.rotation.empty()) return no_rotation(dimension);
    return rotation_in_space(options.rotation);
  }
  void expect_dimension(Eigen::Index expected) const {
    check(dimension == expected, "{}: found a problem in {} dimensions, expected {}", options.type, dimension,
          expected);
  }
};

RegionPtr make_polynomial(const Making& making) {
  const RegionOptions& options = making.options;
  check(options.level.empty() != options.file.empty(), "polynomial: expected one of the keys level and file");
  check(options.sign == 1.0 || options.sign == -1.0, "polynomial: sign is {}, expected 1 or -1",
        options.sign);
  if (!options.level.empty()) {
    return polynomial(Polynomial::from_text(options.level, making.dimension) * options.sign,
                      options.sign > 0.0 ? options.level : fmt::format("-({})", options.level));
  }
  return polynomial(
      Polynomial::from_json(making.files.bytes(options.file), options.file, making.dimension) * options.sign,
      fmt::format("{}polynomial of {}", options.sign > 0.0 ? "" : "-", options.file));
}

RegionPtr make_polygon(const Making& making) {
  making.expect_dimension(2);
  std::vector<Points> holes;
  for (const PolygonHole& hole : making.options.holes) holes.push_back(making.points(hole.vertices, "holes"));
  return polygon(making.points(making.options.vertices, "vertices"), holes);
}

RegionPtr make_polytope(const Making& making) {
  const RegionOptions& options = making.options;
  check(options.vertices.empty() != options.normals.empty(),
        "polytope: expected one of the keys vertices, and normals with offsets");
  if (!options.vertices.empty()) return convex_hull(making.points(options.vertices, "vertices"));
  return polytope(
      making.points(options.normals, "normals"),
      Eigen::Map<const Vector>(options.offsets.data(), static_cast<Eigen::Index>(options.offsets.size())));
}

// What a file says, in its own unit and axes, as the region has it: scaled, turned, then moved.
Points placed_points(const Making& making, const Points& points) {
  const RegionOptions& options = making.options;
  Points result = options.scale * points * making.rotation().matrix.transpose();
  if (!options.center.empty()) result.rowwise() += making.point(options.center, "center").transpose();
  return result;
}

std::string placed_text(const Making& making) {
  const RegionOptions& options = making.options;
  std::string text;
  if (options.scale != 1.0) text += fmt::format(" scale {}", options.scale);
  if (const std::string turned = making.rotation().text; !turned.empty()) text += " " + turned;
  if (!options.center.empty()) text += fmt::format(" at ({})", fmt::join(options.center, ", "));
  return text;
}

const std::string& file_of(const Making& making) {
  check(!making.options.file.empty(), "{}: expected the key file", making.options.type);
  return making.options.file;
}

RegionPtr make_mesh(const Making& making) {
  making.expect_dimension(3);
  const std::string& name = file_of(making);
  TriangleMesh mesh = read_mesh(making.files.bytes(name), name);
  mesh.vertices = placed_points(making, mesh.vertices);
  const auto count = mesh.triangles.rows();
  return solid(std::move(mesh), fmt::format("mesh {} ({} triangles){}", name, count, placed_text(making)));
}

RegionPtr make_point_cloud(const Making& making) {
  const std::string& name = file_of(making);
  const Points points =
      placed_points(making, read_point_cloud(making.files.bytes(name), name, making.dimension));
  Eigen::MatrixXi each(points.rows(), 1);
  each.col(0).setLinSpaced(points.rows(), 0, static_cast<int>(points.rows()) - 1);
  return thickened(SimplexSet(points, each), making.options.radius,
                   fmt::format("points of {} ({}){} radius {}", name, points.rows(), placed_text(making),
                               making.options.radius));
}

RegionPtr make_occupancy_image(const Making& making) {
  making.expect_dimension(2);
  const std::string& name = file_of(making);
  return occupied_cells(read_occupancy_map(name, making.files), making.options.unknown == "occupied",
                        fmt::format("map {}, unknown cells {}", name, making.options.unknown));
}

RegionPtr make(const RegionOptions& options, Eigen::Index dimension, RegionFiles& files);

std::vector<RegionPtr> make_all(const Making& making) {
  std::vector<RegionPtr> regions;
  for (std::size_t i = 0; i < making.options.of.size(); ++i) {
    RegionOptions one = making.options.of[i];
    // Inflating each of a union inflates it, also where one's level is no distance.
    if (making.options.type == "union") one.inflate += making.options.inflate;
    regions.push_back(make_region(one, making.dimension, making.files, fmt::format("of[{}]", i)));
  }
  return regions;
}

RegionPtr make_complement(const Making& making) {
  check(making.options.of.size() == 1, "complement: of has {} regions, expected 1", making.options.of.size());
  return complement(make_all(making).front());
}

RegionPtr make_extrusion(const Making& making) {
  const RegionOptions& options = making.options;
  check(options.of.size() == 1 && making.dimension > 1,
        "extrusion: of has {} regions in {} dimensions, expected 1 region in at least 2", options.of.size(),
        making.dimension);
  return extruded(make_region(options.of.front(), making.dimension - 1, making.files, "of[0]"), options.from,
                  options.to);
}

RegionPtr make_box(const Making& making) {
  const Box box{making.point(making.options.lower, "lower"), making.point(making.options.upper, "upper")};
  // Only a level that is the distance outside inflates to rounded corners.
  return making.options.inflate > 0.0 ? distance_box(box) : box_region(box);
}

using Maker = std::function<RegionPtr(const Making&)>;

// Every type and what makes it, in the order in which messages list them.
const std::vector<std::pair<std::string, Maker>>& makers() {
  static const std::vector<std::pair<std::string, Maker>> all{
      {"none", [](const Making& m) { return empty_region(m.dimension); }},
      {"ball", [](const Making& m) { return ball(m.point(m.options.center, "center"), m.options.radius); }},
      {"box", make_box},
      {"ellipsoid",
       [](const Making& m) {
         return ellipsoid(m.point(m.options.center, "center"), m.point(m.options.semi_axes, "semi_axes"));
       }},
      {"polygon", make_polygon},
      {"oriented_box",
       [](const Making& m) {
         return oriented_box(m.point(m.options.center, "center"), m.point(m.options.half_sizes, "half_sizes"),
                             m.rotation());
       }},
      {"capsule",
       [](const Making& m) {
         return capsule(m.point(m.options.start, "start"), m.point(m.options.end, "end"), m.options.radius);
       }},
      {"cylinder",
       [](const Making& m) {
         m.expect_dimension(3);
         return cylinder(m.point(m.options.start, "start"), m.point(m.options.end, "end"), m.options.radius);
       }},
      {"polytope", make_polytope},
      {"mesh", make_mesh},
      {"point_cloud", make_point_cloud},
      {"occupancy_image", make_occupancy_image},
      {"polynomial", make_polynomial},
      {"halfspace",
       [](const Making& m) { return halfspace(m.point(m.options.normal, "normal"), m.options.offset); }},
      {"expression", [](const Making& m) { return expression(m.options.level, m.dimension); }},
      {"union", [](const Making& m) { return unite(make_all(m)); }},
      {"intersection", [](const Making& m) { return intersect(make_all(m)); }},
      {"complement", make_complement},
      {"arm", [](const Making& m) { return arm_region(m.options, m.dimension, m.files); }},
      {"extrusion", make_extrusion}};
  return all;
}

RegionPtr make(const RegionOptions& options, Eigen::Index dimension, RegionFiles& files) {
  for (const auto& [type, maker] : makers()) {
    if (type != options.type) continue;
    RegionPtr region = maker({options, dimension, files});
    const bool inflate = options.inflate != 0.0 && type != "union" && type != "none";
    return inflate ? inflated(std::move(region), options.inflate) : region;
  }
  fail("type '{}' cannot be used here, expected a set such as ball, box or expression", options.type);
}

std::vector<std::string> types() {
  std::vector<std::string> all;
  for (const auto& [type, maker] : makers()) all.push_back(type);
  all.insert(all.end(), {"auto", "ball_auto"});
  return all;
}

}  // namespace

void PolygonHole::visit(FieldVisitor& v) { v.field("vertices", vertices, any_number()); }

void RegionOptions::visit(FieldVisitor& v) {
  v.field("type", type, types());
  const auto is = [&](std::initializer_list<std::string_view> names) {
    return std::find(names.begin(), names.end(), type) != names.end();
  };
  if (is({"ball", "ellipsoid", "oriented_box", "mesh", "point_cloud"}))
    v.field("center", center, any_number());
  if (is({"ball", "ball_auto", "capsule", "cylinder", "point_cloud"})) v.field("radius", radius, above(0.0));
  if (type == "arm") visit_arm(v);
  if (type == "ellipsoid") v.field("semi_axes", semi_axes, above(0.0));
  if (type == "box") {
    v.field("lower", lower, any_number());
    v.field("upper", upper, any_number());
  }
  if (is({"polygon", "polytope"})) v.field("vertices", vertices, any_number());
  if (type == "polygon") v.list("holes", holes);
  if (type == "oriented_box") v.field("half_sizes", half_sizes, above(0.0));
  if (is({"oriented_box", "mesh", "point_cloud"})) {
    v.field("angle", angle, any_number());
    v.field("rotation", rotation, any_number());
  }
  if (is({"capsule", "cylinder"})) {
    v.field("start", start, any_number());
    v.field("end", end, any_number());
  }
  if (type == "polytope") {
    v.field("normals", normals, any_number());
    v.field("offsets", offsets, any_number());
  }
  if (type == "halfspace") {
    v.field("normal", normal, any_number());
    v.field("offset", offset, any_number());
  }
  if (is({"expression", "polynomial"})) v.field("level", level);
  if (is({"polynomial", "mesh", "point_cloud", "occupancy_image"})) v.field("file", file);
  if (is({"mesh", "point_cloud"})) v.field("scale", scale, above(0.0));
  if (type == "occupancy_image") v.field("unknown", unknown, {"occupied", "free"});
  if (type == "polynomial") v.field("sign", sign, between(-1.0, 1.0));
  if (is({"union", "intersection", "complement", "extrusion"})) v.list("of", of);
  if (type == "extrusion") {
    v.field("from", from, any_number());
    v.field("to", to, any_number());
  }
  if (!is({"none", "auto", "ball_auto"})) v.field("inflate", inflate, at_least(0.0));
}

void RegionOptions::visit_arm(FieldVisitor& v) {
  v.field("dh", dh, any_number());
  v.field("convention", convention, {"modified", "standard"});
  v.field("joint_unit", joint_unit, {"auto", "rad", "deg"});
  v.field("base", base, any_number());
  v.field("rotation", rotation, any_number());
  v.field("radius", radius, at_least(0.0));
  v.field("tip", tip, any_number());
  v.field("spheres", spheres, any_number());
  v.field("capsules", capsules, any_number());
  v.list("obstacles", obstacles);
}

RegionPtr make_region(const RegionOptions& options, Eigen::Index dimension, RegionFiles& files,
                      const std::string& where) {
  check(dimension > 0, "{}: dimension {}, expected at least 1", where, dimension);
  try {
    return make(options, dimension, files);
  } catch (const Error& error) {
    fail("{}: {}", where, error.what());
  }
}

RegionPtr make_region(const RegionOptions& options, Eigen::Index dimension) {
  RegionFiles files;
  return make_region(options, dimension, files, "region");
}

}  // namespace s2nnds
