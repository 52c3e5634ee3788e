// SPDX-License-Identifier: BSD-3-Clause
// One certificate for every displacement of an obstacle: the range, and motions that try to break it.
#include "s2nnds/runs/scene_range.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/evaluation/rollout.h"
#include "s2nnds/networks/moved_motion.h"
#include "s2nnds/problem/boundary_points.h"
#include "s2nnds/problem/extruded_region.h"
#include "s2nnds/runs/displaced_obstacle.h"
#include "s2nnds/runs/range_motions.h"
#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

// A plane in which everything is known: the motion turns in to the goal, the safe set is a disc around a hole, and the
// obstacle lies in the hole. B is no barrier for this f; what a range says of the sets and motions does not depend on it.
struct Plane {
  PreparedRun setup;
  RunRecord record;

  explicit Plane(const RegionOptions& unsafe,
                 const RegionPtr& initial = ball((Vector(2) << -1.0, 0.0).finished(), 0.05),
                 Eigen::Index n = 2) {
    SafetyProblem& problem = setup.problem;
    problem.workspace = Box::cube(n, 1.25);
    problem.contained = Box::cube(n, 1.2);
    problem.workspace_margin = complement(box_region(problem.contained));
    problem.initial = initial;
    setup.config.problem.unsafe = problem.written_unsafe = unsafe;
    problem.unsafe = make_region(unsafe, n);
    setup.config.problem.frame = "normalised";
    setup.data.dimension = n;
    setup.data.frame.unit = "mm";
    setup.data.frame.goal = Vector::Zero(n);
    setup.data.frame.position_scale = 40.0;
    setup.data.frame.velocity_scale = 20.0;
    record.data = setup.data;
    record.problem.frame = "normalised";
    record.problem.workspace = problem.workspace;
    record.networks = simple_networks(n);
    record.networks.f = linear_field((Points(2, 2) << -1.0, -0.5, 0.5, -1.0).finished());
    record.certificate.guarantee = Guarantee::invariant;
    record.certificate.disturbance_margin = 0.01;
  }
  SceneRange range(const SceneRangeOptions& options = {}) const {
    return scene_range(setup, record, options);
  }
};

RegionOptions ball_at(double x, double y, double radius) {
  return {.type = "ball", .center = {x, y}, .radius = radius};
}

std::string refusal(const Plane& plane, const SceneRangeOptions& options = {}) {
  try {
    plane.range(options);
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "";
}

TEST(SceneRange, IsAsLargeAsTheNearestSetAllows) {
  const SceneRange range = Plane(ball_at(-0.4, 0.35, 0.1)).range();
  const double distance = std::hypot(0.4, 0.35);
  EXPECT_EQ(range.limit, "the goal");
  EXPECT_NEAR(range.displacement.outer(), distance, 1e-3);
  EXPECT_LE(range.displacement.outer(), range.displacement.center().norm());
  EXPECT_NEAR(range.radius, 0.6 * (distance - 0.1), 2e-3);
  EXPECT_LE(range.stretch, 0.8 * (1.0 + 1e-12));
  EXPECT_NEAR(range.margin, 0.002, 1e-5);
  EXPECT_LE(range.margin, 0.01 * (1.0 - range.stretch) + 1e-18);
}

TEST(SceneRange, EverySetCanBeTheNearest) {
  const RegionPtr near_start = ball((Vector(2) << -0.4, 0.0).finished(), 0.1);
  EXPECT_EQ(Plane(ball_at(-0.4, 0.35, 0.1), near_start).range().limit, "the initial set");
  EXPECT_NEAR(Plane(ball_at(-0.4, 0.35, 0.1), near_start).range().displacement.outer(), 0.25, 1e-3);
  EXPECT_EQ(Plane(ball_at(0.0, 0.9, 0.1)).range().limit, "the workspace's edge");
  RegionOptions both{.type = "union", .of = {ball_at(-0.4, 0.5, 0.1), ball_at(0.1, 0.5, 0.1)}};
  const SceneRange first = Plane(both).range({.obstacle = 0});
  EXPECT_NE(first.limit.find("the obstacle ball"), std::string::npos);
  EXPECT_NEAR(first.displacement.outer(), 0.4, 1e-3);
  // All as one: the ball around both.
  EXPECT_NEAR(Plane(both).range().displacement.inner(), 0.35, 2e-3);
}

// As problem.tool writes them: copies of all obstacles, one after the other.
TEST(SceneRange, WhatAToolSweepsOfAnObstacleMovesAsOne) {
  const RegionOptions low{.type = "union", .of = {ball_at(-0.4, 0.5, 0.1), ball_at(0.3, 0.5, 0.1)}},
      high{.type = "union", .of = {ball_at(-0.4, 0.6, 0.1), ball_at(0.3, 0.6, 0.1)}},
      all{.type = "union", .of = {low, high}};
  Plane plane(low);
  plane.setup.problem.written_unsafe = all;
  plane.setup.problem.unsafe = make_region(all, 2);
  const SceneRange range = plane.range({.obstacle = 0});
  EXPECT_NEAR(range.displacement.inner(), 0.15, 1e-3);
  EXPECT_NEAR(range.displacement.center()[1], 0.55, 1e-2);
  EXPECT_NE(refusal(plane, {.obstacle = 2}).find("--obstacle 2, expected one of 0 to 1"), std::string::npos);
}

TEST(SceneRange, InflationOfAUnionGrowsItsParts) {
  RegionOptions both{
      .type = "union", .of = {ball_at(-0.4, 0.5, 0.1), ball_at(0.1, 0.5, 0.1)}, .inflate = 0.05};
  const SceneRange first = Plane(both).range({.obstacle = 0});
  EXPECT_NEAR(first.displacement.inner(), 0.15, 1e-3);
  EXPECT_NEAR(first.displacement.outer(), 0.35, 1e-3);
}

TEST(SceneRange, IsClippedByWhatIsWanted) {
  const Plane plane(ball_at(-0.4, 0.35, 0.1));
  const SceneRange whole = plane.range();
  const SceneRange small = plane.range({.radius = 0.1});
  EXPECT_EQ(small.radius, 0.1);
  EXPECT_LT(small.stretch, 0.5 * whole.stretch);
  EXPECT_GT(small.margin, whole.margin);
  EXPECT_EQ(plane.range({.radius = 5.0}).radius, whole.radius);
  const Vector half = (Vector(2) << 0.15, 0.02).finished();
  const SceneRange box = plane.range({.half_sizes = half});
  EXPECT_TRUE(box.holds((Vector(2) << -0.15, 0.02).finished()));
  EXPECT_FALSE(box.holds((Vector(2) << 0.0, 0.021).finished()));
  EXPECT_FALSE(box.holds(Vector::Constant(2, std::nan(""))));
  EXPECT_FALSE(box.holds(Vector::Zero(3)));
  for (const SceneRange& each : {whole, small, box})
    for (Eigen::Index k = 0; k < each.ends().rows(); ++k)
      EXPECT_TRUE(each.holds(each.ends().row(k).transpose()));
}

TEST(SceneRange, RefusesInOneLineAndSaysWhatIsInTheWay) {
  const RegionPtr beside = ball((Vector(2) << -0.4, 0.19).finished(), 0.06);
  EXPECT_NE(refusal(Plane(ball_at(-0.4, 0.35, 0.1), beside)).find("found the initial set within 3.9"),
            std::string::npos)
      << refusal(Plane(ball_at(-0.4, 0.35, 0.1), beside));
  EXPECT_NE(refusal(Plane(ball_at(0.1, 0.0, 0.1))).find("found the goal within "), std::string::npos);
  EXPECT_NE(refusal(Plane(ball_at(1.15, 0.0, 0.1))).find("the workspace's edge"), std::string::npos);
  RegionOptions touching{.type = "union", .of = {ball_at(-0.4, 0.5, 0.1), ball_at(-0.2, 0.5, 0.1)}};
  EXPECT_NE(refusal(Plane(touching), {.obstacle = 1}).find("found the obstacle ball"), std::string::npos);
  // What goes on outside of the workspace would come in from there.
  RegionOptions wall{.type = "box", .lower = {0.3, 0.55}, .upper = {HUGE_VAL, 0.65}};
  EXPECT_NE(refusal(Plane(wall)).find("the workspace's edge"), std::string::npos);
  EXPECT_NE(refusal(Plane({.type = "halfspace", .normal = {1.0, 0.0}, .offset = 2.0})).find("bounded"),
            std::string::npos);
  EXPECT_NE(refusal(Plane({.type = "none"})).find("no obstacle"), std::string::npos);
  EXPECT_NE(refusal(Plane(ball_at(-0.4, 0.35, 0.1)), {.obstacle = 1}).find("--obstacle 1"),
            std::string::npos);
  EXPECT_NE(refusal(Plane(ball_at(-0.4, 0.35, 0.1)), {.stretch = 1.0}).find("stretch"), std::string::npos);
  Plane unproved(ball_at(-0.4, 0.35, 0.1));
  unproved.record.certificate.guarantee = Guarantee::conformal;
  EXPECT_NE(refusal(unproved).find("found the guarantee conformal, expected invariant"), std::string::npos);
}

TEST(SceneRange, MotionsAreTheImagesOfTheUndisplacedOnes) {
  const Plane plane(ball_at(-0.4, 0.35, 0.1));
  const SceneRange range = plane.range();
  const MovedMotion motion(plane.record.networks, range.displacement);
  const Dynamics f = plane.record.networks.dynamics();
  const Vector times = Vector::LinSpaced(40, 0.0, 6.0);
  const RolloutOptions exact{.absolute_tolerance = 1e-10, .relative_tolerance = 1e-10};
  for (Eigen::Index k = 0; k < range.ends().rows(); ++k) {
    const Vector p = range.ends().row(k).transpose();
    const Vector start = (Vector(2) << -0.9, 0.7).finished();
    const Points moved = roll_out_at(StateFunction([&](const Points& x) { return motion.velocity(x, p); }),
                                     start, times, exact);
    const Points image = range.displacement.image(roll_out_at(f, start, times, exact), p);
    EXPECT_LE((moved - image).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(SceneRange, NoDisplacementAndNoPlaceOutsideChangeAnything) {
  const Plane plane(ball_at(-0.4, 0.35, 0.1));
  const SceneRange range = plane.range();
  const MovedMotion motion(plane.record.networks, range.displacement);
  RandomStream random(1, "outside");
  const Points x = Points::NullaryExpr(5000, 2, [&] { return random.uniform(-1.25, 1.25); });
  const auto same = [](const Points& a, const Points& b) {
    return a.size() == b.size() &&
           std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
  };
  EXPECT_TRUE(same(motion.velocity(x, Vector::Zero(2)), plane.record.networks.velocity(x)));
  EXPECT_TRUE(same(motion.barrier(x, Vector::Zero(2)), plane.record.networks.B.value(x)));
  EXPECT_TRUE(same(motion.lyapunov(x, Vector::Zero(2)), plane.record.networks.V.value(x)));
  const Vector p = range.ends().row(3).transpose();
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    const Points one = x.row(k);
    if ((one.row(0).transpose() - range.displacement.center()).norm() <= range.displacement.outer()) continue;
    EXPECT_TRUE(same(motion.velocity(one, p), plane.record.networks.velocity(one)));
    EXPECT_TRUE(same(motion.barrier(one, p), plane.record.networks.B.value(one)));
  }
}

// A field with a true barrier: f turns around the obstacle's place as the flow around a cylinder does, so no motion enters the
// disc, and {|x - c|^2 >= r^2} is invariant. What starts outside stays outside, here by the law and in displaced scenes by
// the theorem.
struct CylinderFlow {
  Vector center = (Vector(2) << -0.4, 0.35).finished();
  double radius = 0.12;  // of what no motion enters: the obstacle's 0.1 and some room

  Points operator()(const Points& x) const {
    Points v(x.rows(), 2);
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      const Vector off = x.row(k).transpose() - center;
      const double square = off.squaredNorm();
      Vector toward = -x.row(k).transpose();
      // Of the way to the goal, what leads into the disc fades out on the edge, and a turn takes its place.
      const double inward = std::min(0.0, toward.dot(off)) / square;
      const double share = std::min(1.0, radius * radius / square);
      toward -= share * inward * off;
      toward += share * (Vector(2) << -off[1], off[0]).finished();
      v.row(k) = toward.transpose();
    }
    return v;
  }
};

// One step of Heun's method for all motions.
template <typename Field>
void advance(Points& x, double step, const Field& field) {
  const Points first = field(x);
  const Points second = field(x + step * first);
  x += 0.5 * step * (first + second);
}

TEST(SceneRange, OfAHundredThousandMotionsNoneTouchesTheMovedObstacle) {
  const Plane plane(ball_at(-0.4, 0.35, 0.1));
  const SceneRange range = plane.range();
  const Displacement& displacement = range.displacement;
  const CylinderFlow f;
  RandomStream random(2, "hundred thousand");
  constexpr Eigen::Index kDisplacements = 100, kMotions = 1000;
  double nearest = HUGE_VAL, farthest_end = 0.0;
  for (Eigen::Index each = 0; each < kDisplacements; ++each) {
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
    const Vector p =
        range.radius * (1.0 - 1e-12) * (Vector(2) << std::cos(angle), std::sin(angle)).finished();
    const auto moved = [&](const Points& x) {
      const Points y = displacement.preimage(x, p);
      return displacement.pushed(y, f(y), p);
    };
    Points y = Points::NullaryExpr(kMotions, 2, [&] { return random.uniform(-1.0, 1.0); });
    for (Eigen::Index k = 0; k < kMotions; ++k) {  // from the edge of the disc on
      const Vector off = y.row(k).transpose() - f.center;
      if (off.norm() < f.radius || k % 2 == 0)
        y.row(k) = (f.center + f.radius * (1.0 + 1e-9) * off.normalized()).transpose();
    }
    Points x = displacement.image(y, p);
    for (int step = 0; step < 200; ++step) {
      advance(x, 0.04, moved);
      nearest = std::min(nearest, (x.rowwise() - (f.center + p).transpose()).rowwise().norm().minCoeff());
    }
    farthest_end = std::max(farthest_end, x.rowwise().norm().maxCoeff());
  }
  EXPECT_GT(nearest, 0.1);  // the obstacle's radius; the disc's is 0.12
  EXPECT_LT(farthest_end, 0.05);
}

TEST(SceneRange, AnObstacleOnItsWayIsNotTouchedEither) {
  const Plane plane(ball_at(-0.4, 0.35, 0.1));
  const SceneRange range = plane.range();
  const Displacement& displacement = range.displacement;
  const CylinderFlow f;
  RandomStream random(3, "on the way");
  Points y = Points::NullaryExpr(5000, 2, [&] { return random.uniform(-1.0, 1.0); });
  for (Eigen::Index k = 0; k < y.rows(); ++k) {
    const Vector off = y.row(k).transpose() - f.center;
    if (off.norm() < f.radius) y.row(k) = (f.center + f.radius * (1.0 + 1e-9) * off.normalized()).transpose();
  }
  // Once around the edge of the range in three units of time: faster than the motion.
  const auto place = [&](double t) {
    return Vector((1.0 - 1e-9) * range.radius *
                  (Vector(2) << std::cos(2.0 * t), std::sin(2.0 * t)).finished());
  };
  const auto rate = [&](double t) {
    return Vector(2.0 * (1.0 - 1e-9) * range.radius *
                  (Vector(2) << -std::sin(2.0 * t), std::cos(2.0 * t)).finished());
  };
  const auto velocity = [&](const Points& x, double t, bool told) {
    const Points before = displacement.preimage(x, place(t));
    Points v = displacement.pushed(before, f(before), place(t));
    if (told) v += displacement.bump(before) * rate(t).transpose();
    return v;
  };
  const auto nearest = [&](bool told) {
    Points x = displacement.image(y, place(0.0));
    double least = HUGE_VAL;
    constexpr double step = 0.005;
    for (int k = 0; k < 1600; ++k) {
      const double t = k * step;
      const Points first = velocity(x, t, told);
      x += 0.5 * step * (first + velocity(x + step * first, t + step, told));
      least = std::min(least,
                       (x.rowwise() - (f.center + place(t + step)).transpose()).rowwise().norm().minCoeff());
    }
    if (told) {
      EXPECT_LT(x.rowwise().norm().maxCoeff(), 0.05);
    }
    return least;
  };
  EXPECT_GT(nearest(true), 0.1);
  EXPECT_LT(nearest(false), 0.1);  // what is not told is not certified
}

// Pushing as hard as the margin allows along grad B_p, where B = 0: seen from before, no push is larger than the margin.
TEST(SceneRange, DisturbancesAreNeverLargerThanTheMarginSeenFromBefore) {
  const Plane plane(ball_at(-0.4, 0.35, 0.1));
  const SceneRange range = plane.range();
  const Displacement& displacement = range.displacement;
  RandomStream random(4, "margin");
  double worst = 0.0;
  for (int k = 0; k < 20000; ++k) {
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
    const Vector direction = (Vector(2) << std::cos(angle), std::sin(angle)).finished();
    const Vector p = range.radius * (1.0 - 1e-12) * direction;
    // The worst places lie where psi is steepest, along p from the center; the others are anywhere.
    const double distance = random.uniform(displacement.inner(), displacement.outer());
    Points y = (displacement.center() + distance * direction).transpose();
    if (k % 2 == 0) y = Points::NullaryExpr(1, 2, [&] { return random.uniform(-1.0, 1.0); });
    Points columns(2, 2);
    columns.row(0) = displacement.pushed(y, (Points(1, 2) << 1.0, 0.0).finished(), p);
    columns.row(1) = displacement.pushed(y, (Points(1, 2) << 0.0, 1.0).finished(), p);
    const Points jacobian = columns.transpose();
    const double determinant = jacobian(0, 0) * jacobian(1, 1) - jacobian(0, 1) * jacobian(1, 0);
    EXPECT_GE(determinant, 1.0 - range.stretch - 1e-12);
    // |DT^-1| in the plane: the largest singular value of DT over the determinant.
    const double square = jacobian.squaredNorm();
    const double largest = std::sqrt(
        0.5 * (square + std::sqrt(std::max(0.0, square * square - 4.0 * determinant * determinant))));
    worst = std::max(worst, range.margin * largest / determinant);
  }
  EXPECT_LE(worst, plane.record.certificate.disturbance_margin);
  EXPECT_GE(worst, 0.98 * plane.record.certificate.disturbance_margin);  // no larger margin would do
}

TEST(SceneRange, OfStatesWithAPhaseMovesPlacesAlone) {
  RegionOptions written{.type = "extrusion", .of = {ball_at(-0.4, 0.35, 0.1)}};
  Plane plane(ball_at(-0.4, 0.35, 0.1));
  SafetyProblem& problem = plane.setup.problem;
  problem.phase_start = 1.0;
  problem.written_unsafe = written;
  problem.unsafe = make_region(written, 3);
  problem.workspace = Box::cube(3, 1.25);
  problem.contained = Box::cube(3, 1.2);
  problem.initial = extruded(problem.initial, 0.98, 1.02);
  const SceneRange range = plane.range();
  EXPECT_EQ(range.displacement.places(), 2);
  EXPECT_NEAR(range.displacement.outer(), std::hypot(0.4, 0.35), 1e-3);
  const SafetyProblem moved = moved_problem(plane.setup, range, range.ends().row(0).transpose());
  const Vector p = range.ends().row(0).transpose();
  EXPECT_TRUE(moved.unsafe->contains((Vector(3) << -0.4 + p[0], 0.35 + p[1], 0.7).finished()));
  EXPECT_FALSE(moved.unsafe->contains((Vector(3) << -0.4 + p[0], 0.35 + p[1] + 0.11, 0.7).finished()));
}

TEST(DisplacedObstacle, IsToldFromOtherChanges) {
  const RegionOptions one = ball_at(-0.4, 0.35, 0.1), moved = ball_at(-0.3, 0.3, 0.1);
  const auto found = displaced_obstacle(one, moved);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->index, -1);
  EXPECT_NEAR(found->p[0], 0.1, 1e-12);
  EXPECT_NEAR(found->p[1], -0.05, 1e-12);
  EXPECT_FALSE(displaced_obstacle(one, one).has_value());
  EXPECT_FALSE(displaced_obstacle(one, ball_at(-0.3, 0.3, 0.11)).has_value());
  const RegionOptions box{.type = "box", .lower = {0.1, 0.2}, .upper = {0.3, 0.4}};
  EXPECT_TRUE(displaced_obstacle(box, {.type = "box", .lower = {0.2, 0.2}, .upper = {0.4, 0.4}}).has_value());
  EXPECT_FALSE(
      displaced_obstacle(box, {.type = "box", .lower = {0.2, 0.2}, .upper = {0.3, 0.4}}).has_value());
  EXPECT_FALSE(displaced_obstacle(one, box).has_value());
  const RegionOptions wall{.type = "box", .lower = {0.1, 0.2}, .upper = {HUGE_VAL, 0.4}};
  EXPECT_FALSE(
      displaced_obstacle(wall, {.type = "box", .lower = {0.2, 0.2}, .upper = {HUGE_VAL, 0.4}}).has_value());
  const RegionOptions half{.type = "halfspace", .normal = {1.0, 0.0}, .offset = 2.0};
  EXPECT_FALSE(
      displaced_obstacle(half, {.type = "halfspace", .normal = {1.0, 0.0}, .offset = 2.1}).has_value());
  const RegionOptions both{.type = "union", .of = {one, box}};
  const auto part = displaced_obstacle(both, {.type = "union", .of = {moved, box}});
  ASSERT_TRUE(part.has_value());
  EXPECT_EQ(part->index, 0);
  EXPECT_FALSE(displaced_obstacle(both, {.type = "union", .of = {moved, box}, .inflate = 0.1}).has_value());
  EXPECT_FALSE(displaced_obstacle(both, {.type = "union", .of = {moved}}).has_value());
}

TEST(SceneRange, StatementHasUnitsAndSaysNoMoreThanIsShown) {
  Plane plane(ball_at(-0.4, 0.35, 0.1));
  const SceneRange range = plane.range();
  const std::string text = range_statement(plane.record, range);
  EXPECT_NE(text.find(fmt::format("by up to {:.4g} mm", std::floor(40.0 * range.radius * 1e3) / 1e3)),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("|w| <= 0.03999 mm/s"), std::string::npos) << text;
  EXPECT_EQ(text.find("as a robot executes"), std::string::npos);
  plane.record.certificate.execution.model = "some model";
  EXPECT_NE(
      range_statement(plane.record, range).find("Nothing is certified of the motion as a robot executes it"),
      std::string::npos);
  plane.record.certificate.disturbance_margin = 0.0;
  EXPECT_EQ(range_statement(plane.record, plane.range()).find("|w|"), std::string::npos);
}

}  // namespace
}  // namespace s2nnds
