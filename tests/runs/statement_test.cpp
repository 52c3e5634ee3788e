// What a certificate says in words must follow from its verdicts, and must not say more.
#include <gtest/gtest.h>

#include "s2nnds/runs/statement.h"

namespace s2nnds {
namespace {

RunRecord record_with(const std::string& guarantee) {
  RunRecord record;
  record.name = "Sine";
  record.seed = 4;
  record.data.unit = "mm";
  record.data.normalization.position_scale = 40.0;
  record.data.normalization.velocity_scale = 50.0;
  record.problem.containment = 0.985;
  record.problem.level_band = 0.01;
  record.problem.workspace = Box::cube(2, 1.25);
  record.certificate.guarantee = guarantee;
  record.certificate.level_band = 0.01;
  return record;
}

bool says(const RunRecord& record, const std::string& words) {
  return guarantee_statement(record).find(words) != std::string::npos;
}

TEST(Statement, OfNothingPromisesNothing) { EXPECT_TRUE(says(record_with("none"), "Nothing is guaranteed")); }

TEST(Statement, NamesWhatSamplesPassedAndAProofRefuted) {
  RunRecord record = record_with("sampled");
  record.certificate.conditions = {
      {.condition = "unsafe", .method = "sampled", .verdict = "passed", .samples = 1234, .witness = {}},
      {.condition = "unsafe", .method = "proof", .verdict = "refuted", .witness = {0.25, -0.5}}};
  EXPECT_TRUE(says(record, "1234 uniform samples"));
  EXPECT_TRUE(says(record, "seed 4"));
  EXPECT_TRUE(says(record, "REFUTED unsafe: it is violated at (0.25, -0.5)")) << guarantee_statement(record);
  record.certificate.conditions.pop_back();
  EXPECT_FALSE(says(record, "REFUTED"));
}

TEST(Statement, OfConformalNamesSamplesEpsilonAndBeta) {
  RunRecord record = record_with("conformal");
  record.certificate.conditions = {{.condition = "unsafe",
                                    .method = "conformal",
                                    .verdict = "passed",
                                    .samples = 250000,
                                    .epsilon = 1e-4,
                                    .beta = 5e-5,
                                    .attempt = 2,
                                    .witness = {}},
                                   {.condition = "initial",
                                    .method = "conformal",
                                    .verdict = "passed",
                                    .samples = 250000,
                                    .epsilon = 1e-4,
                                    .beta = 5e-5,
                                    .attempt = 2,
                                    .witness = {}}};
  for (const char* words : {"confidence 1 - 0.0001", "attempt 2", "250000", "seed 4", "epsilon = 0.0001",
                            "does not prove that every motion is safe"})
    EXPECT_TRUE(says(record, words)) << words << ": " << guarantee_statement(record);
}

TEST(Statement, OfAnInvariantSetSaysWhetherTheMarginCoversFloat32) {
  RunRecord record = record_with("invariant");
  EXPECT_TRUE(says(record, "stays in it for ever"));
  EXPECT_TRUE(says(record, "No margin against disturbances was certified"));
  record.certificate.disturbance_margin = 0.02;
  record.certificate.float32_error = 0.001;
  EXPECT_TRUE(says(record, "0.02 (normalised; 1 mm/s)") || says(record, "normalised; 1 mm/s"))
      << guarantee_statement(record);
  EXPECT_TRUE(says(record, "this margin covers"));
  record.certificate.float32_error = 0.03;
  EXPECT_TRUE(says(record, "does NOT cover"));
}

TEST(Statement, OfProvedConditionsAloneDoesNotSpeakOfWholeMotions) {
  const RunRecord record = record_with("proved");
  EXPECT_FALSE(says(record, "stays in it for ever"));
  EXPECT_TRUE(says(record, "only while it stays inside"));
}

}  // namespace
}  // namespace s2nnds
