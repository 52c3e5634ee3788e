#include "s2nnds/verification/certificate.h"

#include <gtest/gtest.h>

#include <limits>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

TEST(Guarantee, NamesReadBack) {
  for (const Guarantee guarantee :
       {Guarantee::none, Guarantee::sampled, Guarantee::conformal, Guarantee::proved, Guarantee::invariant}) {
    EXPECT_EQ(guarantee_from(to_string(guarantee)), guarantee);
  }
}

TEST(Guarantee, GrowsInStrength) {
  EXPECT_LT(guarantee_from("none"), guarantee_from("sampled"));
  EXPECT_LT(guarantee_from("sampled"), guarantee_from("conformal"));
  EXPECT_LT(guarantee_from("conformal"), guarantee_from("proved"));
  EXPECT_LT(guarantee_from("proved"), guarantee_from("invariant"));
}

TEST(Guarantee, UnknownNameIsAnError) {
  EXPECT_THROW(guarantee_from("certain"), Error);
  EXPECT_THROW(guarantee_from(""), Error);
}

Certificate full_certificate() {
  ConditionVerdict proved;
  proved.condition = "lyapunov_decrease";
  proved.method = "proof";
  proved.verdict = "refuted";
  proved.boxes = 15000;
  proved.open_boxes = 3;
  proved.open_volume = 2.5e-7;
  proved.witness = {0.25, -0.125};
  proved.seconds = 1.5;
  ConditionVerdict calibrated;
  calibrated.condition = "initial";
  calibrated.method = "conformal";
  calibrated.verdict = "passed";
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
  certificate.guarantee = "conformal";
  certificate.method = "proof";
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
  Certificate certificate = full_certificate();
  certificate.conditions[0].verdict = "probably";
  EXPECT_THROW(validate(certificate), Error);
}

}  // namespace
}  // namespace s2nnds
