// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/arm_region.h"

#include <gtest/gtest.h>

#include <cmath>

#include "region_attack.h"
#include "s2nnds/problem/arm_bodies.h"

namespace s2nnds {
namespace {

constexpr double kFirst = 0.5, kSecond = 0.4;  // links of a planar arm [m]

// Two joints in the plane z = 0, a ball of 0.1 at (0.55, 0.45), bodies as `bodies` says.
std::string planar(const std::string& bodies, const std::string& obstacles) {
  return "type = \"arm\"\ndh = [[0, 0, 0, 0], [0.5, 0, 0, 0]]\n" + bodies + "\nobstacles = [" + obstacles +
         "]\n";
}
const std::string kBall = "{ type = \"ball\", center = [0.55, 0.45, 0.0], radius = 0.1 }";

Eigen::Vector3d elbow(const Vector& q) { return {kFirst * std::cos(q[0]), kFirst * std::sin(q[0]), 0.0}; }
Eigen::Vector3d hand(const Vector& q) {
  return elbow(q) + Eigen::Vector3d(kSecond * std::cos(q[0] + q[1]), kSecond * std::sin(q[0] + q[1]), 0.0);
}
double segment_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& x) {
  const Eigen::Vector3d along = b - a;
  return (x - a - std::clamp(along.dot(x - a) / along.squaredNorm(), 0.0, 1.0) * along).norm();
}

const Box kSquare{Vector{{-1.5, -2.5}}, Vector{{2.5, 2.5}}};

// One sphere at the hand: the closed form.
TEST(ArmRegion, OfTwoJointsIsTheClosedForm) {
  const RegionPtr arm = region_of(planar("spheres = [[2, 0.4, 0, 0, 0.05]]", kBall), 2);
  const Eigen::Vector3d ball(0.55, 0.45, 0.0);
  const double scale = std::hypot(kFirst + kSecond, kSecond);
  EXPECT_TRUE(arm->is_lipschitz());
  attack(
      arm, kSquare, [&](const Vector& q) { return ((hand(q) - ball).norm() - 0.15) / scale; }, 3000);
}

TEST(ArmRegion, TakesDegreesOffsetsAndABase) {
  const RegionPtr rad = region_of(planar("radius = 0.05\ntip = [0.4, 0, 0]", kBall), 2);
  const RegionPtr deg = region_of(planar("radius = 0.05\ntip = [0.4, 0, 0]\njoint_unit = \"deg\"", kBall), 2);
  // The base turned by 90 degrees about z and moved, offsets that undo the turn.
  const RegionPtr moved = region_of(
      "type = \"arm\"\ndh = [[0, 0, 0, -1.5707963267948966], [0.5, 0, 0, 0]]\nradius = 0.05\ntip = [0.4, 0, "
      "0]\n"
      "base = [1.0, 2.0, 3.0]\nrotation = [0, 0, 1, 1]\n"
      "obstacles = [{ type = \"ball\", center = [1.55, 2.45, 3.0], radius = 0.1 }]\n",
      2);
  RandomStream random(1, "arm-region-test");
  for (int k = 0; k < 500; ++k) {
    const Points q{{random.uniform(-1.5, 2.5), random.uniform(-2.5, 2.5)}};
    const double level = rad->level(q)[0];
    EXPECT_NEAR(deg->level(q * (180.0 / M_PI))[0], level * (180.0 / M_PI), 1e-11);
    EXPECT_NEAR(moved->level(q)[0], level, 1e-12);
  }
  attack(
      deg, {kSquare.lower * 57.0, kSquare.upper * 57.0},
      [&](const Vector& q) { return rad->level(q.transpose() * (M_PI / 180.0))[0] * (180.0 / M_PI); }, 1000,
      1e-10);
}

// Wherever a link, a capsule, meets the obstacle the set holds the joint position, and it holds little more.
TEST(ArmRegion, HoldsEveryTouchOfItsLinks) {
  const Eigen::Vector3d ball(0.55, 0.45, 0.0);
  const RegionPtr arm = region_of(planar("radius = 0.05\ntip = [0.4, 0, 0]", kBall), 2);
  RandomStream random(2, "arm-region-test");
  int met = 0, more = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vector q{{random.uniform(-1.5, 2.5), random.uniform(-2.5, 2.5)}};
    const double distance =
        std::min(segment_distance({0, 0, 0}, elbow(q), ball), segment_distance(elbow(q), hand(q), ball));
    const bool touches = distance <= 0.15;
    met += touches;
    more += !touches && arm->contains(q);
    if (touches) {
      ASSERT_TRUE(arm->contains(q)) << q.transpose();
    }
    if (arm->contains(q)) {
      ASSERT_LE(distance, 0.15 + 0.08 * 0.05) << q.transpose();
    }
  }
  EXPECT_GT(met, 1000);
  EXPECT_LT(more, met / 20);
}

// The level of spheres that move with frames, by the level of the obstacle alone.
double by_spheres(const KinematicChain& chain, const std::vector<BodySphere>& spheres,
                  const RegionPtr& obstacle, const Vector& q) {
  const auto frames = chain.frames(std::vector<double>(q.begin(), q.end()));
  double least = 1e300;
  for (const BodySphere& sphere : spheres) {
    const auto& pose = frames[static_cast<std::size_t>(sphere.frame)];
    const auto turned = pose.turned(sphere.center);
    Points center(1, 3);
    for (std::size_t i = 0; i < 3; ++i) center(0, static_cast<Eigen::Index>(i)) = pose.origin[i] + turned[i];
    least = std::min(least, obstacle->level(center)[0] - sphere.radius);
  }
  return least;
}

constexpr char kFranka[] =
    "type = \"arm\"\n"
    "dh = [[0, 0, 0.333, 0], [0, -1.5707963267948966, 0, 0], [0, 1.5707963267948966, 0.316, 0],\n"
    "  [0.0825, 1.5707963267948966, 0, 0], [-0.0825, -1.5707963267948966, 0.384, 0],\n"
    "  [0, 1.5707963267948966, 0, 0], [0.088, 1.5707963267948966, 0, 0]]\n"
    "tip = [0, 0, 0.107]\nradius = 0.06\n"
    "capsules = [[7, 0, -0.08, 0.12, 0, 0.08, 0.12, 0.04]]\n";

RegionOptions options_of(const std::string& toml) {
  RegionOptions options;
  read_toml(toml, "test", options);
  return options;
}

// The same of seven joints with a capsule across the hand; links of the arm as lines between the origins.
TEST(ArmRegion, HoldsEveryTouchInSpace) {
  const Eigen::Vector3d ball(0.4, 0.3, 0.5);
  const RegionOptions options = options_of(
      kFranka + std::string("obstacles = [{ type = \"ball\", center = [0.4, 0.3, 0.5], radius = 0.1 }]"));
  const RegionPtr arm = make_region(options, 7);
  const KinematicChain chain(options.dh, DhConvention::modified, Vector::Zero(3), no_rotation(3));
  RandomStream random(12, "arm-region-test");
  int met = 0;
  for (int k = 0; k < 20000; ++k) {
    std::vector<double> q;
    for (int j = 0; j < 7; ++j) q.push_back(random.uniform(-2.8, 2.8));
    const auto frames = chain.frames(q);
    const auto place = [&](std::size_t frame, const Eigen::Vector3d& at) {
      const auto turned = frames[frame].turned(at);
      const auto& origin = frames[frame].origin;
      return Eigen::Vector3d(origin[0] + turned[0], origin[1] + turned[1], origin[2] + turned[2]);
    };
    double over = segment_distance(place(7, {0, 0, 0}), place(7, {0, 0, 0.107}), ball) - 0.06;
    over =
        std::min(over, segment_distance(place(7, {0, -0.08, 0.12}), place(7, {0, 0.08, 0.12}), ball) - 0.04);
    for (std::size_t i = 1; i < 7; ++i) {
      const Eigen::Vector3d a = place(i, {0, 0, 0}), b = place(i + 1, {0, 0, 0});
      over =
          std::min(over, ((b - a).norm() > 1e-9 ? segment_distance(a, b, ball) : (a - ball).norm()) - 0.06);
    }
    const bool touches = over <= 0.1, held = arm->contains(Eigen::Map<const Vector>(q.data(), 7));
    met += touches;
    ASSERT_FALSE(touches && !held) << "at " << k;
    ASSERT_FALSE(held && over > 0.1 + 0.08 * 0.06) << "at " << k << ": " << over;
  }
  EXPECT_GT(met, 300);
}

// Boxes of joint positions against points of them, in three and seven joints and for several kinds of obstacle.
TEST(ArmRegion, ClassifiesBoxesSoundly) {
  const std::vector<std::string> obstacles = {
      "{ type = \"ball\", center = [0.4, 0.3, 0.5], radius = 0.15 }",
      "{ type = \"box\", lower = [0.3, -0.6, 0.0], upper = [0.6, -0.2, 0.5] }",
      "{ type = \"capsule\", start = [0.4, 0.3, 0.0], end = [0.4, 0.3, 0.8], radius = 0.1, inflate = 0.02 }",
      "{ type = \"union\", of = [{ type = \"halfspace\", normal = [0.0, 0.0, 1.0], offset = 0.02 },"
      " { type = \"oriented_box\", center = [0.5, 0.2, 0.5], half_sizes = [0.1, 0.3, 0.1], rotation = [0.1, "
      "0.2, 0.3, 0.9] }] }",
      "{ type = \"expression\", level = \"(x - 0.4)^2 + (y - 0.3)^2 + (z - 0.5)^2 - 0.0225\" }"};
  const std::string three =
      "type = \"arm\"\nconvention = \"standard\"\n"
      "dh = [[0, 1.5707963267948966, 0.4, 0], [0.4, 0, 0, 0.3], [0.35, 0, 0.05, -0.2]]\nradius = 0.05\n";
  RandomStream random(9, "arm-region-test");
  for (const std::string& obstacle : obstacles) {
    const bool exact = obstacle.find("expression") == std::string::npos;
    for (const std::string& head : {three, std::string(kFranka)}) {
      const RegionOptions options = options_of(head + "obstacles = [" + obstacle + "]\n");
      const auto joints = std::ssize(options.dh);
      const RegionPtr arm = make_region(options, joints);
      EXPECT_EQ(arm->is_lipschitz(), exact);
      const KinematicChain chain(
          options.dh, options.convention == "standard" ? DhConvention::standard : DhConvention::modified,
          Vector::Zero(3), no_rotation(3));
      const auto spheres =
          cover_bodies({options.radius, options.tip, options.spheres, options.capsules}, chain);
      RegionOptions grown = options.obstacles.front();
      if (grown.type == "box") grown.inflate = 1e-12;  // so that the level is the distance
      const RegionPtr alone = make_region(grown, 3);
      int inside = 0, outside = 0;
      for (int k = 0; k < (exact ? 1500 : 60); ++k) {
        const Box box =
            random_box(random, {Vector::Constant(joints, -2.5), Vector::Constant(joints, 2.5)}, 0.6);
        const Location location = arm->classify(box);
        const Interval bound = arm->enclosure(box);
        inside += location == Location::inside;
        outside += location == Location::outside;
        for (int i = 0; i < 12; ++i) {
          Vector q(joints);
          for (Eigen::Index j = 0; j < joints; ++j) {
            const double share = i < 6 ? std::floor(random.uniform(0.0, 2.0)) : random.uniform();
            q[j] = std::min(box.upper[j], box.lower[j] + share * (box.upper[j] - box.lower[j]));
          }
          const double level = arm->level(q.transpose())[0], meets = by_spheres(chain, spheres, alone, q);
          ASSERT_LE(bound.lower, level + 1e-12);
          ASSERT_GE(bound.upper, level - 1e-12);
          // An obstacle whose level is no distance grows by more than it must.
          if (meets < -1e-11 && exact) {
            ASSERT_LT(level, 0.0);
          }
          if (meets > 1e-11 && exact) {
            ASSERT_GT(level, 0.0);
          }
          ASSERT_FALSE(exact && location == Location::outside && meets < -1e-11);
          ASSERT_FALSE(exact && location == Location::inside && meets > 1e-11);
        }
      }
      EXPECT_GT(outside, exact ? 100 : 1) << arm->describe();
      if (exact) {
        EXPECT_GT(inside, 10) << arm->describe();
      }
    }
  }
}

// The level is never more than the distance in joint space.
TEST(ArmRegion, LevelIsOneLipschitz) {
  const RegionPtr arm = region_of(
      kFranka + std::string("obstacles = [{ type = \"ball\", center = [0.4, 0.3, 0.5], radius = 0.1 }]"), 7);
  RandomStream random(6, "arm-region-test");
  for (int k = 0; k < 3000; ++k) {
    Points q(2, 7);
    const double apart = std::pow(10.0, random.uniform(-3.0, 0.3));
    for (Eigen::Index j = 0; j < 7; ++j) {
      q(0, j) = random.uniform(-2.5, 2.5);
      q(1, j) = q(0, j) + apart * random.uniform(-1.0, 1.0);
    }
    const Vector level = arm->level(q);
    ASSERT_LE(std::abs(level[0] - level[1]), (q.row(0) - q.row(1)).norm() * (1.0 + 1e-9) + 1e-12);
  }
  // Many at a time are the same as one at a time.
  const Points many = Points::Random(1300, 7);
  const Vector level = arm->level(many);
  for (Eigen::Index k = 0; k < many.rows(); k += 97) EXPECT_EQ(level[k], arm->level(many.row(k))[0]);
}

TEST(ArmRegion, LeavesOutWhatDoesNotMove) {
  // The first link of the Franka arm stands still: a floor below it is not touched.
  const RegionPtr floor = region_of(
      kFranka + std::string("obstacles = [{ type = \"halfspace\", normal = [0, 0, 1], offset = 0.1 }]"), 7);
  EXPECT_FALSE(floor->contains(Vector{{0, -0.8, 0, -2.3, 0, 1.6, 0.8}}));
  EXPECT_TRUE(floor->contains(Vector{{0, 1.7, 0, -0.1, 0, 1.6, 0.8}}));
}

TEST(ArmRegion, SurvivesARoundTrip) {
  const RegionOptions options =
      options_of(kFranka + std::string("base = [0.1, 0, 0]\nrotation = [0, 0, 1, 1]\njoint_unit = "
                                       "\"deg\"\nspheres = [[3, 0, 0, 0.1, 0.02]]\n"
                                       "obstacles = [{ type = \"ball\", center = [0.4, 0.3, 0.5], radius = "
                                       "0.1 }, { type = \"box\", lower = "
                                       "[1, 1, 0], upper = [2, 2, 1] }]"));
  const RegionOptions again = options_of(to_toml(options));
  EXPECT_EQ(to_toml(again), to_toml(options));
  const Points q = 90.0 * Points::Random(50, 7);
  EXPECT_EQ(make_region(again, 7)->level(q), make_region(options, 7)->level(q));
}

TEST(ArmRegion, RefusesWhatIsNotWellWritten) {
  const auto refusal = [&](const std::string& toml, Eigen::Index joints = 2) {
    return message_of([&] { region_of(toml, joints); });
  };
  expect_message(refusal(planar("radius = 0.1", kBall), 3),
                 "region: arm: dh has 2 rows [a, alpha, d, theta], expected 3, one a joint");
  expect_message(
      refusal("type = \"arm\"\ndh = [[0, 0, 0], [0.5, 0, 0, 0]]\nradius = 0.1\nobstacles = [" + kBall + "]"),
      "dh[0]: found 3 numbers, expected 4");
  expect_message(
      refusal("type = \"arm\"\ndh = [[0, 0, 0, nan], [0.5, 0, 0, 0]]\nradius = 0.1\nobstacles = [" + kBall +
              "]"),
      "nan");
  expect_message(
      refusal("type = \"arm\"\ndh = [[0, 0, 0, inf], [0.5, 0, 0, 0]]\nradius = 0.1\nobstacles = [" + kBall +
              "]"),
      "dh[0]: found inf, expected a finite number");
  expect_message(refusal(planar("", kBall)),
                 "found no bodies, expected radius (of all links), spheres or capsules");
  expect_message(refusal(planar("radius = -0.1", kBall)), "radius");
  expect_message(refusal(planar("spheres = [[3, 0, 0, 0, 0.1]]", kBall)),
                 "spheres[0]: found frame 3, expected one of 0 (the base) to 2");
  expect_message(refusal(planar("spheres = [[1.5, 0, 0, 0, 0.1]]", kBall)), "found frame 1.5");
  expect_message(refusal(planar("spheres = [[1, 0, 0, 0]]", kBall)),
                 "spheres[0]: found 4 numbers, expected 5: frame, x, y, z, radius");
  expect_message(refusal(planar("spheres = [[1, 0, 0, 0, 0]]", kBall)),
                 "spheres[0]: found radius 0, expected > 0");
  expect_message(refusal(planar("capsules = [[1, 0, 0, 0, 0.1]]", kBall)),
                 "capsules[0]: found 5 numbers, expected 8");
  expect_message(refusal(planar("spheres = [[0, 1, 0, 0, 0.1]]", kBall)), "found no body that a joint moves");
  expect_message(refusal(planar("radius = 0.1\ntip = [0.4, 0]", kBall)), "tip: found 2 numbers, expected 3");
  expect_message(refusal(planar("radius = 0.1\nbase = [0.4, 0]", kBall)),
                 "base: found 2 numbers, expected 3");
  expect_message(refusal(planar("radius = 0.1\nrotation = [0.4, 0]", kBall)),
                 "arm: rotation: found 2 numbers");
  expect_message(refusal(planar("radius = 0.1\nconvention = \"craig\"", kBall)), "convention");
  expect_message(refusal(planar("radius = 0.1", "")), "found no obstacles");
  expect_message(refusal(planar("radius = 0.1", "{ type = \"ball\", center = [1.0, 1.0], radius = 0.1 }")),
                 "arm: obstacles[0]: ball: center has 2 numbers, expected 3");
  expect_message(
      refusal(planar("radius = 0.1", "{ type = \"polygon\", vertices = [[0, 0], [1, 0], [0, 1]] }")),
      "obstacles[0]: polygon");
  expect_message(
      refusal(planar("radius = 0.1", "{ type = \"union\", of = [{ type = \"arm\", radius = 0.1 }] }")),
      "found an arm as an obstacle");
  const RegionPtr arm = region_of(planar("radius = 0.1", kBall), 2);
  expect_message(message_of([&] { arm->level(Points{{0.1, NAN}}); }), "the level is not a number at");
}

}  // namespace
}  // namespace s2nnds
