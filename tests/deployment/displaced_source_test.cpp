// SPDX-License-Identifier: BSD-3-Clause
// The displaced scenes of an exported header against the library's.
#include "s2nnds/deployment/displaced_source.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "random_policy.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/deployment/export_format.h"
#include "s2nnds/networks/moved_motion.h"

namespace s2nnds {
namespace {

namespace fs = std::filesystem;

constexpr double kScale = 40.0, kSpeed = 25.0;

class DisplacedSource : public testing::Test {
 protected:
  DisplacedSource()
      : folder_(fs::temp_directory_path() / ("s2nnds-displaced-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~DisplacedSource() override { fs::remove_all(folder_); }

  Policy policy_in(int n) {
    Networks networks;
    networks.f = random_stack({n, 40, 17, n}, Activation::tanh, true, false, random_);
    networks.f.head = Head::zero_at_origin;
    networks.V = random_stack({n, 20, 9}, Activation::tanh, true, false, random_);
    networks.V.head = Head::squared_norm;
    networks.V.quadratic = 0.3;
    networks.B = random_stack({n, 16, 1}, Activation::tanh, true, false, random_);
    return random_policy(networks);
  }

  // Rows of velocity [n], lyapunov, barrier, safe, displaced of rows x [n], p, rate in the data's unit.
  Points ask(const Points& rows, int n) {
    const std::string command = fmt::format(
        "{} -std=c++17 -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Werror -O2 "
        "-march=native -I{} "
        "'-DPOLICY_HEADER=\"policy.h\"' -DPOLICY_NAMESPACE=policy_policy "
        "{}/tests/deployment/displaced_driver.cpp -o {}",
        S2NNDS_CXX_COMPILER, folder_.string(), S2NNDS_SOURCE_DIR, (folder_ / "driver").string());
    check(std::system(command.c_str()) == 0, "the driver did not compile");
    {
      std::ofstream numbers(folder_ / "numbers.txt");
      for (Eigen::Index i = 0; i < rows.size(); ++i) numbers << fmt::format("{:.17g}\n", rows.data()[i]);
    }
    check(std::system(fmt::format("{} < {} > {}", (folder_ / "driver").string(),
                                  (folder_ / "numbers.txt").string(), (folder_ / "results.txt").string())
                          .c_str()) == 0,
          "the driver failed");
    std::ifstream results(folder_ / "results.txt");
    Points found(rows.rows(), n + 4);
    std::string word;
    for (double& value : found.reshaped<Eigen::RowMajor>()) {
      results >> word;
      value = std::strtod(word.c_str(), nullptr);
    }
    results >> allocations_;
    return found;
  }

  fs::path folder_;
  RandomStream random_{13, "displaced source"};
  long allocations_ = -1;
};

TEST_F(DisplacedSource, AnswersAsTheLibraryWithoutAllocating) {
  struct Case {
    int n, places;
  };
  for (const auto [n, places] : {Case{2, 2}, Case{3, 3}, Case{3, 2}}) {
    const Policy policy = policy_in(n);
    SceneRange range{.displacement = Displacement(Vector::LinSpaced(places, -0.4, 0.3), 0.1, 0.5)};
    range.radius = range.displacement.largest(0.95);
    export_policy(policy, export_format_from("header"), {HeaderPrecision::float64, range},
                  (folder_ / "policy.h").string());
    constexpr Eigen::Index count = 3000;
    Points z = Points::NullaryExpr(count, n, [&] { return random_.uniform(-1.0, 1.0); });
    Points p(count, places);
    const Points rate = Points::NullaryExpr(count, places, [&] { return random_.uniform(-1.0, 1.0); });
    for (Eigen::Index k = 0; k < count; ++k) {
      const Vector direction = Vector::NullaryExpr(places, [&] { return random_.normal(); }).normalized();
      p.row(k) = (k % 5 == 0 ? 0.0 : 1.0 - 1e-9) * range.radius * direction.transpose();
      if (k % 2 == 0)
        z.row(k).head(places) = 0.5 * z.row(k).head(places) + range.displacement.center().transpose();
    }
    Points rows(count, n + 2 * places);
    rows << positions(z), kScale * p, kSpeed * rate;
    const Points found = ask(rows, n);
    const MovedMotion motion(policy.networks, range.displacement);
    double worst = 0.0;
    for (Eigen::Index k = 0; k < count; ++k) {
      const Vector by = p.row(k).transpose();
      const Points at = z.row(k), v = motion.velocity(at, by, rate.row(k).transpose());
      worst = std::max({worst, (found.row(k).head(n) / kSpeed - v.row(0)).norm(),
                        std::abs(found(k, n) - motion.lyapunov(at, by)(0, 0)),
                        std::abs(found(k, n + 1) - motion.barrier(at, by)(0, 0))});
      EXPECT_EQ(found(k, n + 3), 1.0);
    }
    EXPECT_LE(worst, 1e-10) << n << ", " << places;
    EXPECT_EQ(allocations_, 0);
  }
}

TEST_F(DisplacedSource, NothingIsAnsweredOutsideOfTheRange) {
  const Policy policy = policy_in(2);
  SceneRange range{.displacement = Displacement((Vector(2) << -0.4, 0.3).finished(), 0.1, 0.5)};
  range.radius = range.displacement.largest(0.8);
  range.half_sizes = (Vector(2) << 1.0, 0.05).finished();
  export_policy(policy, export_format_from("header"), {HeaderPrecision::float64, range},
                (folder_ / "policy.h").string());
  const double far = 1.001 * kScale * range.radius;
  const Points rows = (Points(4, 6) << 512.0, -250.0, far, 0.0, 0.0, 0.0,  //
                       512.0, -250.0, 0.0, 0.051 * kScale, 0.0, 0.0,       //
                       512.0, -250.0, std::nan(""), 0.0, 0.0, 0.0,         //
                       std::nan(""), -250.0, 1.0, 0.0, 0.0, 0.0)
                          .finished();
  const Points found = ask(rows, 2);
  for (Eigen::Index k = 0; k < 3; ++k) {
    EXPECT_EQ(found.row(k).head(2).norm(), 0.0);
    EXPECT_EQ(found(k, 4), 0.0);
    EXPECT_EQ(found(k, 5), 0.0);
  }
  EXPECT_TRUE(std::isnan(found(3, 0)));
  EXPECT_EQ(found(3, 4), 0.0);
}

TEST_F(DisplacedSource, OtherFormatsRefuseARange) {
  const Policy policy = policy_in(2);
  const SceneRange range{.displacement = Displacement(Vector::Constant(2, 0.4), 0.1, 0.5), .radius = 0.1};
  EXPECT_THROW(export_policy(policy, export_format_from("onnx"), {HeaderPrecision::float32, range},
                             (folder_ / "policy.onnx").string()),
               Error);
  EXPECT_FALSE(fs::exists(folder_ / "policy.onnx"));
}

}  // namespace
}  // namespace s2nnds
