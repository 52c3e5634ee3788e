// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/orientation_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/data/orientation.h"

namespace s2nnds {
namespace {

// B < 0 everywhere: -1.
NetworkWeights negative() {
  NetworkWeights barrier;
  barrier.layers = {{Points::Zero(1, 3), Vector::Constant(1, -1.0), Activation::identity}};
  return barrier;
}

class OrientationFit : public testing::Test {
 protected:
  OrientationFit() {
    frame_.goal_orientation = quaternion_of({2.0, 0.3, -0.4});
    frame_.quaternion_order = "xyzw";
    frame_.position_scale = 0.5;
    frame_.velocity_scale = 0.25;  // 2 s a unit of time
    for (int k = 0; k < 4; ++k) {
      Demonstration d{Vector::LinSpaced(80, 0.0, 2.0), Points(80, 3), Points::Zero(80, 3)};
      Points r(80, 3);
      for (Eigen::Index i = 0; i < 80; ++i) {
        const double left = 1.0 - static_cast<double>(i) / 79.0;
        d.position.row(i) << left, (0.5 + 0.05 * k) * std::sin(3.0 * left), -0.4 * left * left;
        r.row(i) << 1.1 * left, 0.6 * std::sin(3.0 * left), 0.3 * left;
      }
      d.orientation = orientations(frame_.goal_orientation, r);
      shown_.push_back(std::move(d));
    }
  }
  OrientationLaw fit(const OrientationOptions& options = {}, std::uint64_t seed = 3) const {
    return fit_orientation(shown_, frame_, negative(), Box::cube(3, 1.25), options, seed);
  }

  Frame frame_;
  std::vector<Demonstration> shown_;
};

TEST_F(OrientationFit, FollowsTheDemonstrationsAndVanishesAtTheGoal) {
  const OrientationLaw law = fit();
  law.check(3);
  double largest = 0.0;
  for (const Demonstration& d : shown_)
    largest = std::max(largest,
                       (law.psi.value(d.position) - rotation_vectors(frame_.goal_orientation, d.orientation))
                           .rowwise()
                           .norm()
                           .maxCoeff());
  EXPECT_LT(degrees(largest), 3.0);
  EXPECT_NEAR(degrees(law.initial_error), degrees(largest) + 10.0, 1e-9);
  EXPECT_EQ(law.psi.value(Points::Zero(1, 3)), Points::Zero(1, 3));
  EXPECT_NEAR(law.rate, 5.0 / 4.0, 1e-12);  // 4 s
  // Nowhere in the workspace does it turn so far that the bound would fail.
  RandomStream random(1, "test");
  const Points z = Points::NullaryExpr(5000, 3, [&] { return random.uniform(-1.25, 1.25); });
  EXPECT_LT(law.psi.value(z).rowwise().norm().maxCoeff() + law.initial_error, M_PI);
}

TEST_F(OrientationFit, IsTheSameForOneSeedAndTakesWhatIsAsked) {
  EXPECT_EQ(fit().hash(), fit().hash());
  EXPECT_NE(fit().hash(), fit({}, 4).hash());
  const OrientationLaw law = fit({.features = 40, .rate = 2.5, .initial_error = 30});
  EXPECT_EQ(law.psi.layers[0].weight.rows(), 40);
  EXPECT_EQ(law.rate, 2.5);
  EXPECT_NEAR(degrees(law.initial_error), 30.0, 1e-12);
  frame_.goal_orientation = {};
  EXPECT_THROW(fit(), Error);
}

}  // namespace
}  // namespace s2nnds
