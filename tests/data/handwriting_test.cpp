// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/handwriting.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/data/readers.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

class Handwriting : public testing::TestWithParam<std::string> {};

TEST_P(Handwriting, IsASoundSetOfSevenThatEndAtRestInTheOrigin) {
  const DemonstrationSet set = handwriting(GetParam());
  check_demonstrations(set, GetParam());
  EXPECT_EQ(set.unit, "mm");
  EXPECT_EQ(set.demonstrations.size(), 7U);
  EXPECT_EQ(set.dimension(), GetParam() == "Helix" ? 3 : 2);
  for (const Demonstration& d : set.demonstrations) {
    EXPECT_EQ(d.samples(), 1000);
    EXPECT_EQ(d.time[0], 0);
    EXPECT_EQ(d.position.row(999).norm(), 0);
    EXPECT_EQ(d.velocity.row(0).norm(), 0);
    EXPECT_EQ(d.velocity.row(999).norm(), 0);
  }
}

TEST_P(Handwriting, VelocityIsTheDerivativeOfThePosition) {
  for (const Demonstration& d : handwriting(GetParam()).demonstrations) {
    const double fastest = d.velocity.cwiseAbs().maxCoeff();
    EXPECT_LT((differentiate(d.time, d.position) - d.velocity).cwiseAbs().maxCoeff(), 1e-4 * fastest);
  }
}

TEST_P(Handwriting, DemonstrationsDifferByAFewPercentOfTheirSize) {
  const DemonstrationSet set = handwriting(GetParam());
  const double size = stack_positions(set.demonstrations).cwiseAbs().maxCoeff();
  EXPECT_GT(size, 30);
  EXPECT_LT(size, 60);
  Points starts(7, set.dimension());
  for (Eigen::Index k = 0; k < 7; ++k) {
    starts.row(k) = set.demonstrations[static_cast<std::size_t>(k)].position.row(0);
  }
  const Points offsets = starts.rowwise() - starts.colwise().mean();
  const double spread = std::sqrt(offsets.squaredNorm() / static_cast<double>(offsets.size()));
  EXPECT_GT(spread, 0.02 * size);
  EXPECT_LT(spread, 0.08 * size);
}

// What a law xdot = f(x) needs: where the motion is under way, no two samples of any demonstrations lie close
// together and move in opposite directions.
TEST_P(Handwriting, NearbySamplesMoveAlike) {
  std::vector<Demonstration> thin = handwriting(GetParam()).demonstrations;
  for (Demonstration& d : thin) {
    const auto middle =
        Eigen::seq(150, 850, 10);  // the first and last instants have no direction to speak of
    d = {d.time(middle), d.position(middle, Eigen::all), d.velocity(middle, Eigen::all)};
    d.velocity.rowwise().normalize();
  }
  const Points position = stack_positions(thin);
  const Points direction = stack_velocities(thin);
  const double close = 0.04 * position.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < position.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      if ((position.row(i) - position.row(j)).norm() > close) continue;
      ASSERT_GT(direction.row(i).dot(direction.row(j)), std::cos(2 * M_PI / 3))
          << position.row(i) << " and " << position.row(j);
    }
  }
}

TEST_P(Handwriting, IsTheSameEveryTime) {
  const DemonstrationSet a = handwriting(GetParam());
  const DemonstrationSet b = handwriting(GetParam());
  EXPECT_EQ(stack_positions(a.demonstrations), stack_positions(b.demonstrations));
  EXPECT_NE(a.demonstrations[0].position, a.demonstrations[1].position);
}

INSTANTIATE_TEST_SUITE_P(Motions, Handwriting, testing::ValuesIn(handwriting_motions()),
                         [](const auto& each) { return each.param; });

TEST(HandwritingMotions, AnUnknownOneIsNamedBesideTheKnown) {
  expect_error([] { handwriting("Sinus"); },
               "found motion 'Sinus'; expected one of Sine, S, C, N, Spiral, Helix");
}

}  // namespace
}  // namespace s2nnds
