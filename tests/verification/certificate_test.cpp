// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/certificate.h"

#include <gtest/gtest.h>

#include <limits>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

TEST(EnumNames, ReadBack) {
  for (const std::string_view name : EnumNames<Guarantee>::names)
    EXPECT_EQ(to_string(enum_from<Guarantee>(name)), name);
  for (const Condition condition : all_conditions)
    EXPECT_EQ(enum_from<Condition>(to_string(condition)), condition);
  EXPECT_EQ(to_string(Verdict::undecided), "undecided");
  EXPECT_EQ(to_string(Method::proof), "proof");
}

TEST(EnumNames, UnknownNameIsAnErrorThatListsTheKnown) {
  EXPECT_THROW(enum_from<Guarantee>(""), Error);
  try {
    enum_from<Method>("guess");
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "method: found \"guess\", expected one of sampled, conformal, proof");
  }
}

Certificate full_certificate() {
  ConditionVerdict proved;
  proved.condition = Condition::lyapunov_decrease;
  proved.method = Method::proof;
  proved.verdict = Verdict::refuted;
  proved.boxes = 15000;
  proved.open_boxes = 3;
  proved.open_volume = 2.5e-7;
  proved.witness = {0.25, -0.125};
  proved.seconds = 1.5;
  ConditionVerdict calibrated;
  calibrated.condition = Condition::initial;
  calibrated.method = Method::conformal;
  calibrated.verdict = Verdict::passed;
  calibrated.samples = 250000;
  calibrated.violations = 2;
  calibrated.seed = 7;
  calibrated.worst = -0.5;
  calibrated.epsilon = 1e-4;
  calibrated.beta = 1e-5;
  calibrated.attempt = 3;
  calibrated.order = 9;
  calibrated.quantile = -0.625;
  calibrated.tightest_epsilon = 3e-5;
  Certificate certificate;
  certificate.guarantee = Guarantee::conformal;
  certificate.side.goal_is_safe = true;
  certificate.weight_hash = "ab12";
  certificate.attempts = 3;
  certificate.level_band = 0.05;
  certificate.disturbance_margin = 0.01;
  certificate.convergence_radius = 0.125;
  certificate.statement = "What holds.";
  certificate.conditions = {proved, calibrated};
  return certificate;
}

TEST(Certificate, EveryFieldSurvivesAFile) {
  const Certificate written = full_certificate();
  Certificate read;
  read_toml(to_toml(written), "certificate.toml", read);
  EXPECT_EQ(flatten(read), flatten(written));
  ASSERT_EQ(read.conditions.size(), 2U);
  EXPECT_EQ(read.conditions[0].witness, written.conditions[0].witness);
  EXPECT_EQ(read.conditions[1].tightest_epsilon, 3e-5);
  EXPECT_EQ(read.statement, "What holds.");
}

TEST(Certificate, InfiniteResidualsSurviveAFile) {
  Certificate written = full_certificate();
  written.conditions[1].worst = std::numeric_limits<double>::infinity();
  Certificate read;
  read_toml(to_toml(written), "certificate.toml", read);
  EXPECT_EQ(read.conditions[1].worst, std::numeric_limits<double>::infinity());
}

TEST(Certificate, UnknownVerdictIsAnError) {
  std::string text = to_toml(full_certificate());
  text.replace(text.find("refuted"), 7, "perhaps");
  Certificate read;
  EXPECT_THROW(read_toml(text, "certificate.toml", read), Error);
}

}  // namespace
}  // namespace s2nnds
