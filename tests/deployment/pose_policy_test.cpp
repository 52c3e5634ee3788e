// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "random_policy.h"
#include "s2nnds/core/check.h"
#include "s2nnds/data/orientation.h"
#include "s2nnds/deployment/cpp_header.h"

namespace s2nnds {
namespace {

namespace fs = std::filesystem;

class PosePolicy : public testing::TestWithParam<const char*> {
 protected:
  PosePolicy() : folder_(fs::temp_directory_path() / fmt::format("s2nnds-pose-policy-{}", ::getpid())) {
    fs::create_directories(folder_);
  }
  ~PosePolicy() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  Policy policy(int n, const std::string& order) {
    Networks networks;
    networks.f = random_stack({n, 40, 17, n}, Activation::tanh, true, false, random_);
    networks.f.head = Head::zero_at_origin;
    networks.V = random_stack({n, 9, 3}, Activation::tanh, true, false, random_);
    networks.V.head = Head::squared_norm;
    networks.B = random_stack({n, 9, 1}, Activation::tanh, true, false, random_);
    Policy made = random_policy(networks);
    OrientationLaw law;
    law.psi = random_stack({n, 37, 3}, Activation::tanh, true, false, random_);
    law.psi.layers.back().bias = {};
    law.psi.head = Head::zero_at_origin;
    law.rate = 1.7;
    law.initial_error = 0.4;
    made.orientation = law;
    made.info.quaternion_order = order;
    const Eigen::Vector4d goal = to_order(goal_, order);
    made.info.goal_orientation = {goal.begin(), goal.end()};
    made.info.orientation_rate = law.rate;
    made.info.orientation_error = law.initial_error;
    made.info.orientation_proved = 1;
    return made;
  }

  // [N, n + 3] of positions and orientations in the user's order.
  Points ask(const Points& x, const Points& q) const { return ask_displaced(x, q, Points(x.rows(), 0)); }

  // The same where an obstacle is displaced by p [N, places], unless that is [N, 0].
  Points ask_displaced(const Points& x, const Points& q, const Points& p) const {
    const std::string command = fmt::format(
        "{} -std=c++17 -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -O1 "
        "'-DPOLICY_HEADER=\"policy.h\"' "
        "-DPOLICY_NAMESPACE=policy_policy {} -I{} {}/tests/deployment/pose_driver.cpp -o {} 2> {}",
        S2NNDS_CXX_COMPILER, p.cols() > 0 ? "-DDISPLACED" : "", folder_.string(), S2NNDS_SOURCE_DIR,
        path("driver"), path("errors.txt"));
    if (std::system(command.c_str()) != 0) {
      std::stringstream text;
      text << std::ifstream(path("errors.txt")).rdbuf();
      fail("{}", text.str());
    }
    {
      std::ofstream points(path("points.txt"));
      for (Eigen::Index i = 0; i < x.rows(); ++i) {
        for (const double value : x.row(i)) points << fmt::format("{:.17g}\n", value);
        for (const double value : q.row(i)) points << fmt::format("{:.17g}\n", value);
        for (const double value : p.row(i)) points << fmt::format("{:.17g}\n", value);
      }
    }
    const std::string run =
        fmt::format("{} < {} > {}", path("driver"), path("points.txt"), path("results.txt"));
    check(std::system(run.c_str()) == 0, "the driver failed");
    std::ifstream results(path("results.txt"));
    Points found(x.rows(), x.cols() + 3);
    std::string word;
    for (Eigen::Index i = 0; i < found.size() && results >> word; ++i)
      found.data()[i] = std::strtod(word.c_str(), nullptr);
    return found;
  }

  fs::path folder_;
  RandomStream random_{12, "pose policy"};
  Eigen::Vector4d goal_ = quaternion_of({1.1, -2.0, 0.6});
};

// Where an obstacle is displaced, positions move as those of a policy without poses do, and q turns as at y = T_p^-1(x).
TEST_P(PosePolicy, TurnsAsWhereTheObstacleWas) {
  const Policy made = policy(3, GetParam());
  const Displacement displacement(Vector::LinSpaced(3, -0.4, 0.3), 0.2, 0.9);
  SceneRange range{.displacement = displacement, .radius = displacement.largest(0.8)};
  export_policy(made, export_format_from("header"), {HeaderPrecision::float64, range}, path("policy.h"));
  const Points z = Points::NullaryExpr(200, 3, [&] { return random_.uniform(-0.8, 0.8); });
  const Points q = Points::NullaryExpr(200, 4, [&] { return random_.normal(); });
  Points p = Points::NullaryExpr(200, 3, [&] { return random_.normal(); });
  for (Eigen::Index k = 0; k < p.rows(); ++k) p.row(k) *= 0.9 * range.radius / p.row(k).norm();
  Points y = z;
  for (Eigen::Index k = 0; k < z.rows(); ++k)
    y.row(k) = displacement.preimage(z.row(k), p.row(k).transpose()).row(0);
  const Points before = ask(positions(y), q), moved = ask_displaced(positions(z), q, 40.0 * p);
  EXPECT_LE((moved.rightCols(3) - before.rightCols(3)).cwiseAbs().maxCoeff(), 1e-9);
  double worst = 0.0;
  for (Eigen::Index k = 0; k < z.rows(); ++k) {
    const Points pushed = displacement.pushed(y.row(k), before.row(k).head(3), p.row(k).transpose());
    worst = std::max(worst, (moved.row(k).head(3) - pushed.row(0)).norm());
  }
  EXPECT_LE(worst, 1e-9);
}

TEST_P(PosePolicy, TheHeaderTurnsAsTheLawDoes) {
  const std::string order = GetParam();
  for (const int n : {2, 3}) {
    const Policy made = policy(n, order);
    export_policy(made, export_format_from("header"), {HeaderPrecision::float64}, path("policy.h"));
    const Points z = Points::NullaryExpr(200, n, [&] { return random_.uniform(-1.25, 1.25); });
    Points r = Points::NullaryExpr(200, 3, [&] { return random_.normal(); });
    r.topRows(3) *= 1e-9;  // at the goal's orientation
    const Points q = orientations(goal_, r);
    Points given(200, 4);
    for (Eigen::Index i = 0; i < 200; ++i) {
      const double size = i % 2 == 0 ? -0.99 : 1.01;  // another sign, no unit quaternion
      given.row(i) = size * to_order(q.row(i).transpose(), order).transpose();
    }
    const Points found = ask(positions(z), given);
    const Points v = 25.0 * made.networks.f.value(z);
    const Points omega = made.orientation->angular_velocity(goal_, z, v / 40.0, q);
    EXPECT_LE((found.leftCols(n) - v).cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_LE((found.rightCols(3) - omega).cwiseAbs().maxCoeff(), 1e-11) << order;
  }
}

TEST_P(PosePolicy, NanAndNoOrientationGiveNan) {
  const Policy made = policy(3, GetParam());
  export_policy(made, export_format_from("header"), {}, path("policy.h"));
  Points q = Points::Zero(2, 4);
  q.row(1).setConstant(std::nan(""));
  const Points found = ask(positions(Points::Zero(2, 3)), q);
  EXPECT_TRUE(found.rightCols(3).array().isNaN().all());
}

TEST_P(PosePolicy, OtherFormatsAreRefusedAndTheLawIsChecked) {
  Policy made = policy(3, GetParam());
  EXPECT_THROW(export_policy(made, export_format_from("torchscript"), {}, path("p.pt")), Error);
  EXPECT_THROW(export_policy(made, export_format_from("pt2"), {}, path("p.pt2")), Error);
  made.info.quaternion_order.clear();
  EXPECT_THROW(check_policy(made), Error);
}

INSTANTIATE_TEST_SUITE_P(Orders, PosePolicy, testing::Values("xyzw", "wxyz"));

}  // namespace
}  // namespace s2nnds
