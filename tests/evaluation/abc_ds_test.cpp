// SPDX-License-Identifier: BSD-3-Clause
// The published ABC-DS polynomials give the published figures: that pins down the definitions of MSE, SD and
// area.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "s2nnds/data/frame.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/evaluation/safe_area.h"
#include "s2nnds/evaluation/trajectory_metrics.h"
#include "s2nnds/problem/polynomial.h"

namespace s2nnds {
namespace {

struct Published {
  std::string motion;
  double mse, sd,
      area;  // over all seven demonstrations, normalised by the largest Euclidean norms; in [-1, 1]^2
};

void PrintTo(const Published& published, std::ostream* out) { *out << published.motion; }

class AbcDs : public testing::TestWithParam<Published> {
 protected:
  void SetUp() override {
    const std::string data = S2NNDS_SHARED_DATA;
    const std::string file = data + "/abc_ds/" + GetParam().motion + "_result.json";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs the published ABC-DS results: " << file;
    result_ = nlohmann::json::parse(std::ifstream(file));
    const DemonstrationSet set = make_demonstrations(read_lasa(data + "/lasa/" + GetParam().motion + ".mat"));
    demonstrations_ = find_frame(set, "max_norm", {"each"}).normalize(set.demonstrations);
  }

  Polynomial polynomial(const nlohmann::json& text) const {
    return Polynomial::from_text(text.is_array() ? text.at(0).get<std::string>() : text.get<std::string>(),
                                 2);
  }

  nlohmann::json result_;
  std::vector<Demonstration> demonstrations_;
};

TEST_P(AbcDs, VelocityErrorsArePublished) {
  ASSERT_EQ(demonstrations_.size(), 7U);
  const Points position = stack_positions(demonstrations_);
  Points predicted(position.rows(), 2);
  for (Eigen::Index k = 0; k < 2; ++k) {
    predicted.col(k) = polynomial(result_.at("f_fh_str_arr").at(static_cast<std::size_t>(k))).value(position);
  }
  const Points velocity = stack_velocities(demonstrations_);
  EXPECT_NEAR(mean_squared_error(predicted, velocity), GetParam().mse, 5e-5);
  EXPECT_NEAR(error_deviation(predicted, velocity), GetParam().sd, 5e-5);
}

TEST_P(AbcDs, SafeAreaIsPublished) {
  const Polynomial barrier = polynomial(result_.at("B_fh_str_arr"));
  const auto level = [&](const Points& x) { return barrier.value(x); };
  // The published figure is the share of the points of a 401 x 401 grid that reaches from edge to edge, in
  // units of 4 / all: cell centres of a box that is half a spacing larger.
  const Box grown = Box::cube(2, 1.0 + 0.5 / 200);
  EXPECT_NEAR(sublevel_area(level, grown, 401) * 4.0 / grown.volume(), GetParam().area, 5e-4);
  // The area itself, from cell centres, is within a thousandth of it.
  EXPECT_NEAR(sublevel_area(level, Box::cube(2, 1.0), 400), GetParam().area, 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Motions, AbcDs,
                         testing::Values(Published{"Sine", 0.0257, 0.0835, 2.851},
                                         Published{"Sshape", 0.0137, 0.0636, 3.748},
                                         Published{"Worm", 0.0634, 0.1296, 3.176},
                                         Published{"PShape", 0.0464, 0.1124, 3.070}),
                         [](const auto& instance) { return instance.param.motion; });

}  // namespace
}  // namespace s2nnds
