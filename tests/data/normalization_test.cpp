#include "s2nnds/data/normalization.h"

#include <gtest/gtest.h>

#include "s2nnds/data/handwriting.h"
#include "s2nnds/data/readers.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

Demonstration two_samples() {
  Demonstration d{Vector(2), Points(2, 2), Points(2, 2)};
  d.time << 0, 0.5;
  d.position << -3, 4, 0, 0;
  d.velocity << 6, -8, 0, 10;
  return d;
}

TEST(Normalization, KnownScales) {
  const Normalization abs = find_normalization("max_abs", {two_samples()});
  EXPECT_DOUBLE_EQ(abs.position_scale, 4);
  EXPECT_DOUBLE_EQ(abs.velocity_scale, 10);
  const Normalization norm = find_normalization("max_norm", {two_samples()});
  EXPECT_DOUBLE_EQ(norm.position_scale, 5);
  EXPECT_DOUBLE_EQ(norm.velocity_scale, 10);
  EXPECT_DOUBLE_EQ(norm.time_scale(), 0.5);
}

TEST(Normalization, TheLargestCoordinateOrNormIsOneOverAllDemonstrations) {
  const std::vector<Demonstration> raw = handwriting("Helix").demonstrations;
  const std::vector<Demonstration> abs = normalize(raw, find_normalization("max_abs", raw));
  EXPECT_NEAR(stack_positions(abs).cwiseAbs().maxCoeff(), 1, 1e-15);
  EXPECT_NEAR(stack_velocities(abs).cwiseAbs().maxCoeff(), 1, 1e-15);
  const std::vector<Demonstration> norm = normalize(raw, find_normalization("max_norm", raw));
  EXPECT_NEAR(stack_positions(norm).rowwise().norm().maxCoeff(), 1, 1e-15);
  EXPECT_NEAR(stack_velocities(norm).rowwise().norm().maxCoeff(), 1, 1e-15);
}

TEST(Normalization, VelocityStaysTheDerivativeOfPosition) {
  const std::vector<Demonstration> raw = handwriting("Sine").demonstrations;
  const Normalization scales = find_normalization("max_abs", raw);
  for (const Demonstration& d : normalize(raw, scales)) {
    EXPECT_LT((differentiate(d.time, d.position) - d.velocity).cwiseAbs().maxCoeff(), 1e-4);
  }
}

TEST(Normalization, ScalingTheDataScalesTheScalesAndNothingElse) {
  const std::vector<Demonstration> raw = handwriting("C").demonstrations;
  std::vector<Demonstration> metres = raw;
  for (Demonstration& d : metres) {
    d.position /= 1024;
    d.velocity /= 1024;
  }
  const std::vector<Demonstration> a = normalize(raw, find_normalization("max_norm", raw));
  const std::vector<Demonstration> b = normalize(metres, find_normalization("max_norm", metres));
  EXPECT_TRUE(stack_positions(a).isApprox(stack_positions(b), 1e-14));
  EXPECT_TRUE(a[0].time.isApprox(b[0].time, 1e-14));
}

TEST(Normalization, MisuseIsRejected) {
  Demonstration still = two_samples();
  still.velocity.setZero();
  expect_error([&] { find_normalization("max_abs", {still}); }, "expected a motion");
  expect_error([] { find_normalization("max_abs", {}); }, "found no samples");
  expect_error([] { find_normalization("largest", {two_samples()}); },
               "found 'largest'; expected max_abs or max_norm");
}

TEST(Split, HoldsOutWholeDemonstrations) {
  const Split split = split_demonstrations(7, {6, 0});
  EXPECT_EQ(split.test, (std::vector<std::int64_t>{6, 0}));
  EXPECT_EQ(split.train, (std::vector<std::int64_t>{1, 2, 3, 4, 5}));
  EXPECT_EQ(split_demonstrations(2, {}).train, (std::vector<std::int64_t>{0, 1}));
  const Split three = split_demonstrations(7, {5, 6}, {4, 0});
  EXPECT_EQ(three.train, (std::vector<std::int64_t>{1, 2, 3}));
  EXPECT_EQ(three.validation, (std::vector<std::int64_t>{4, 0}));
}

TEST(Split, BadIndicesAreRejected) {
  expect_error([] { split_demonstrations(7, {7}); }, "found index 7; expected 0 to 6");
  expect_error([] { split_demonstrations(7, {-1}); }, "found index -1");
  expect_error([] { split_demonstrations(7, {2, 2}); }, "found index 2 twice");
  expect_error([] { split_demonstrations(7, {2}, {2}); }, "found index 2 twice");
  expect_error([] { split_demonstrations(2, {1, 0}); }, "expected at least 1 left");
}

TEST(Split, SelectKeepsTheOrderAskedFor) {
  const std::vector<Demonstration> all = handwriting("N").demonstrations;
  const std::vector<Demonstration> chosen = select(all, {4, 1});
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0].position, all[4].position);
  EXPECT_EQ(chosen[1].position, all[1].position);
  expect_error([&] { select(all, {9}); }, "found index 9; expected 0 to 6");
}

}  // namespace
}  // namespace s2nnds
