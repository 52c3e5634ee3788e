// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/core/points.h"
#include "s2nnds/problem/box.h"
#include "s2nnds/problem/interval.h"
#include "s2nnds/problem/polynomial.h"
#include "s2nnds/problem/region_files.h"

namespace s2nnds {

// How a box lies to a region.
enum class Location { inside, outside, unknown };

// All x with normal . x <= offset.
struct HalfspaceBound {
  Vector normal;  // [n]
  double offset;
};

// A closed set {x in R^n : level(x) <= 0}, in the coordinates in which it is written.
class Region {
 public:
  virtual ~Region() = default;

  virtual Eigen::Index dimension() const = 0;  // n
  // The level function at N points [N, n] -> [N]; negative inside. Throws Error on a wrong dimension, and
  // when the level is not a number somewhere.
  Vector level(const Points& x) const;
  // Whether level(x) <= 0 at one point [n]; throws as level().
  bool contains(const Eigen::Ref<const Vector>& x) const;
  // Sound in floating point: `inside` only if every point of the box is in the set, `outside` only if none
  // is. Also unknown: empty boxes, boxes with NaN, and those where the level may not be defined.
  Location classify(const Box& box) const;
  // Holds the exact level of every point of the box [n]; undefined (NaN) when that cannot be said.
  Interval enclosure(const Box& box) const;
  // A half-space that surely holds every point x of the box [n] with exact level(x) <= `level`, >= 0, and touches the set of
  // these points near the box; nothing where no such one is known.
  virtual std::optional<HalfspaceBound> bounding_halfspace(const Box&, double) const { return std::nullopt; }
  // Whether the exact level is 1-Lipschitz: |level(x) - level(y)| <= |x - y|. It is then at most the distance
  // from the set outside of it, and minus it at most the distance from the complement inside.
  virtual bool is_lipschitz() const = 0;
  // One line for reports and certificates: "ball centre (-0.4, 0.35) radius 0.1".
  virtual std::string describe() const = 0;

 protected:
  // What level() returns after checking: x [N, n] has the right dimension, `level` becomes [N].
  virtual void evaluate(const Points& x, Vector& level) const = 0;
  virtual Interval enclose(const Box& box) const = 0;  // what enclosure() returns, of a box that is not empty
};
// A region as problems hold it: shared and constant.
using RegionPtr = std::shared_ptr<const Region>;

// A hole of a polygon, as a configuration writes it.
struct PolygonHole {
  std::vector<std::vector<double>> vertices = {};  // its corners [x, y], three or more

  void visit(FieldVisitor& v);  // names the key
};

// A region as a configuration writes it: type and the keys of that type, coordinates as the problem's are.
struct RegionOptions {
  // "none" (the empty set), ball, box, ellipsoid, polygon (2-D), oriented_box, capsule, cylinder (3-D), polytope
  // (convex), mesh (3-D), point_cloud, occupancy_image (2-D), polynomial, halfspace, expression, union,
  // intersection, complement, extrusion; of joint angles also arm; for an initial set also auto and ball_auto
  // (safety_problem.h)
  std::string type = "none";
  std::vector<double> center = {};  // ball, ellipsoid, oriented_box: [n]; mesh, point_cloud: where the file's
                                    // origin lies, [n] or none
  // ball, ball_auto, capsule, cylinder; point_cloud: around every point; > 0; arm: of capsules from each frame's origin
  // to the next, 0: none
  double radius = 0.0;
  std::vector<double> semi_axes = {};  // ellipsoid: [n], > 0, sum ((x_i - center_i) / semi_axes_i)^2 <= 1
  std::vector<double> lower = {};      // box: the least coordinates, [n], -infinity allowed
  std::vector<double> upper = {};      // box: the greatest coordinates, [n], infinity allowed
  // polygon: its corners [[x, y], ...], no edge may cross another; polytope: the points whose convex hull it is
  // (2-D or 3-D), instead of `normals`
  std::vector<std::vector<double>> vertices = {};
  std::vector<PolygonHole> holes = {};  // polygon: rings within it that are not part of it
  std::vector<double> half_sizes = {};  // oriented_box: half of each side, [n], > 0
  double angle = 0.0;                   // oriented_box, point_cloud in 2-D: radians, counter-clockwise
  // oriented_box, mesh, point_cloud in 3-D, the base of an arm: a quaternion (x, y, z, w) or the nine numbers of a
  // rotation matrix, row by row; none: not turned
  std::vector<double> rotation = {};
  std::vector<double> start = {};                 // capsule, cylinder: one end of the axis, [n]
  std::vector<double> end = {};                   // capsule, cylinder: the other end, [n]
  std::vector<std::vector<double>> normals = {};  // polytope: one [n] a half-space, normals . x <= offsets
  std::vector<double> offsets = {};               // polytope: one number a half-space
  std::vector<double> normal = {};                // halfspace: [n], not 0, normal . x <= offset
  double offset = 0.0;                            // halfspace: the bound of normal . x
  std::string level = {};  // expression, polynomial: closed form in x, y, z or x1..xn, <= 0 inside
  // Below the data folder. polynomial: published coefficients (JSON: coefs, monomials) instead of `level`; mesh:
  // closed, .stl or .obj; point_cloud: .csv, .txt, .xyz, .ply, .pcd, .npy; occupancy_image: .yaml of a ROS map
  std::string file = {};
  double scale = 1.0;  // mesh, point_cloud: of the file's numbers, > 0: 0.001 for mm in a problem in m
  std::string unknown = "occupied";  // occupancy_image: what unknown cells and all beyond the map count as
  double sign = 1.0;                 // polynomial: inside where sign * p <= 0; 1 or -1
  // union, intersection: one region or more; complement: one; extrusion: one in a dimension less, which holds whatever
  // the last coordinate is
  std::vector<RegionOptions> of = {};
  // extrusion: the least last coordinate, -infinity allowed
  double from = -std::numeric_limits<double>::infinity();
  // extrusion: the greatest last coordinate, infinity allowed
  double to = std::numeric_limits<double>::infinity();
  // arm: [a, alpha, d, theta] of each joint, lengths in the unit of `obstacles`, angles in rad; theta is added to the joint's
  std::vector<std::vector<double>> dh = {};
  std::string convention = "modified";  // arm: of dh, "modified" (Craig) or "standard"
  std::string joint_unit = "auto";      // arm: "rad", "deg", or "auto": data.unit
  std::vector<double> base = {};  // arm: where its frame 0 lies among the obstacles, [3]; none: at the origin
  std::vector<double> tip = {};   // arm: where its last link ends, [3] in the last frame; none: there
  std::vector<std::vector<double>> spheres = {};   // arm: more bodies, [frame, x, y, z, radius]; 0: the base
  std::vector<std::vector<double>> capsules = {};  // arm: more bodies, [frame, x, y, z, x, y, z, radius]
  std::vector<RegionOptions> obstacles = {};       // arm: what it must not touch, one region in space or more
  // >= 0: all points within this distance count as well, such as a tool's radius; arm: joint angles within it
  double inflate = 0.0;

  void visit(FieldVisitor& v);  // names only the keys that `type` has

 private:
  void visit_arm(FieldVisitor& v);
};

// Builds the region in n = `dimension`. Throws Error saying which key of which region is wrong; `where` names
// the region in it. `files` has what `file` names.
RegionPtr make_region(const RegionOptions& options, Eigen::Index dimension, RegionFiles& files,
                      const std::string& where);
// The same where no file must be kept.
RegionPtr make_region(const RegionOptions& options, Eigen::Index dimension);

// Whether the box may meet the region: no only where it surely does not. Boxes of which that is not known are bisected so
// many times at most, since enclosures of large boxes are wide.
bool may_meet(const Region& region, const Box& box, int bisections);

RegionPtr empty_region(Eigen::Index dimension);  // level +infinity
// |x - center| <= radius; level: the signed distance. Throws Error unless center [n] is finite and radius is
// finite and > 0.
RegionPtr ball(const Vector& center, double radius);
// level: inside the signed distance, outside the largest coordinate's excess. Throws Error if `box` is empty.
RegionPtr box_region(const Box& box);
// sum ((x_i - center_i) / semi_axes_i)^2 <= 1; level: (the root of the sum - 1) times the smallest semi-axis.
// Throws Error unless center and semi_axes are both [n] and finite and the semi-axes > 0.
RegionPtr ellipsoid(const Vector& center, const Vector& semi_axes);
// normal . x <= offset; level: the signed distance. Throws Error if normal [n] is 0 or one is not finite.
RegionPtr halfspace(const Vector& normal, double offset);
// level: the closed form, as parse_expression() reads it. Throws Error as it does.
RegionPtr expression(const std::string& level, Eigen::Index dimension);
RegionPtr polynomial(const Polynomial& level, const std::string& name);  // `name` is how describe() calls it
// level: the least of the regions' levels. Throws Error if there is none or their dimensions differ.
RegionPtr unite(std::vector<RegionPtr> regions);
// level: the greatest of the regions' levels. Throws Error as unite() does.
RegionPtr intersect(std::vector<RegionPtr> regions);
RegionPtr complement(RegionPtr region);  // level: minus the region's; closed, so the boundary belongs to both

}  // namespace s2nnds
