// SPDX-License-Identifier: BSD-3-Clause
// What a certificate says in words must follow from its verdicts, and must not say more.
#include "s2nnds/runs/statement.h"

#include <gtest/gtest.h>

namespace s2nnds {
namespace {

RunRecord record_with(Guarantee guarantee) {
  RunRecord record;
  record.name = "Sine";
  record.seed = 4;
  record.data.frame.unit = "mm";
  record.data.frame.position_scale = 40.0;
  record.data.frame.velocity_scale = 50.0;
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

ConditionVerdict verdict_of(Condition condition, Method method, Verdict verdict) {
  ConditionVerdict found;
  found.condition = condition;
  found.method = method;
  found.verdict = verdict;
  return found;
}

TEST(Statement, OfNothingPromisesNothingAndSaysWhy) {
  RunRecord record = record_with(Guarantee::none);
  EXPECT_TRUE(says(record, "Nothing is guaranteed: nothing was checked"));
  auto& conditions = record.certificate.conditions;
  conditions = {verdict_of(Condition::initial, Method::proof, Verdict::undecided)};
  EXPECT_TRUE(says(record, "Nothing is guaranteed. The proof left open: initial."));
  conditions.push_back(verdict_of(Condition::unsafe, Method::sampled, Verdict::failed));
  EXPECT_TRUE(says(record, "Nothing is guaranteed. Samples violate: unsafe."));
  conditions.push_back(verdict_of(Condition::barrier_decrease, Method::proof, Verdict::refuted));
  EXPECT_TRUE(says(record, "Nothing is guaranteed. The proof refuted: barrier_decrease."));
}

TEST(Statement, KeepsStabilityAndSafetyApart) {
  RunRecord record = record_with(Guarantee::conformal);
  EXPECT_EQ(stability_sentence(record), "");
  record.certificate.stability = {.proved = true, .decay = 0.1, .lipschitz = 0.9, .overshoot = 19.0};
  record.certificate.conditions = {verdict_of(Condition::unsafe, Method::conformal, Verdict::passed)};
  record.certificate.conditions[0].epsilon = 1e-4;
  record.certificate.conditions[0].beta = 2e-5;
  // 0.1 a normalised time of 0.8 s.
  EXPECT_TRUE(
      says(record,
           "Stability is proved: every motion of x' = f(x), from any state, converges to the goal (V falls "
           "at least as fast as exp(-0.1249 t), t in s). With confidence 1 - 2e-05, each condition"))
      << guarantee_statement(record);
  EXPECT_TRUE(says(record, "a motion that converges may meet it"));
  record.certificate.guarantee = Guarantee::none;
  EXPECT_TRUE(says(record, "Stability is proved"));
  EXPECT_TRUE(says(record, "Nothing is guaranteed"));
  record.certificate.stability = {.decay = 0.1, .reason = "it is not so"};
  EXPECT_TRUE(says(record, "Stability is NOT proved: it is not so."));
}

TEST(Statement, OfSamplesNamesNumberAndSeed) {
  RunRecord record = record_with(Guarantee::sampled);
  record.certificate.conditions = {verdict_of(Condition::unsafe, Method::sampled, Verdict::passed)};
  record.certificate.conditions[0].samples = 1234;
  EXPECT_TRUE(says(record, "1234 uniform samples"));
  EXPECT_TRUE(says(record, "seed 4"));
  EXPECT_FALSE(says(record, "REFUTED"));
}

TEST(Statement, ShowsTheWitnessOfARefutationInTheUnitOfTheData) {
  RunRecord record = record_with(Guarantee::none);
  record.certificate.conditions = {verdict_of(Condition::unsafe, Method::proof, Verdict::refuted)};
  record.certificate.conditions[0].witness = {0.25, -0.5};
  EXPECT_TRUE(says(record, "REFUTED unsafe: it is violated at (0.25, -0.5), which is (10, -20) mm"))
      << guarantee_statement(record);
  record.data.frame.unit = "";
  EXPECT_TRUE(says(record, "(10, -20) units of the data from the goal.")) << guarantee_statement(record);
}

TEST(Statement, SpeaksOfTheDatasFrameAlone) {
  RunRecord record = record_with(Guarantee::invariant);
  record.data.frame.goal = Vector{{500.0, 200.0}};
  record.data.frame.name = "base_link";
  record.problem.frame = "data";
  record.problem.unsafe = "ball centre (300, 400) radius 40";
  record.certificate.disturbance_margin = 0.02;
  record.certificate.conditions = {verdict_of(Condition::unsafe, Method::proof, Verdict::refuted)};
  record.certificate.conditions[0].witness = {0.25, -0.5};
  const std::string found = guarantee_statement(record);
  for (const char* words : {"REFUTED unsafe: it is violated at (510, 180) mm.", "|w| <= 1 mm/s,",
                            "(frame base_link), in mm: the goal is",
                            "the goal is (500, 200) mm, the workspace (450, 150) mm to (550, 250) mm",
                            "ball centre (300, 400) radius 40"})
    EXPECT_TRUE(says(record, words)) << words << ": " << found;
  EXPECT_EQ(found.find("normalised"), std::string::npos) << found;
}

TEST(Statement, OfConformalNamesSamplesEpsilonAndBeta) {
  RunRecord record = record_with(Guarantee::conformal);
  record.certificate.conditions = {{.condition = Condition::unsafe,
                                    .method = Method::conformal,
                                    .verdict = Verdict::passed,
                                    .samples = 250000,
                                    .epsilon = 1e-4,
                                    .beta = 5e-5,
                                    .attempt = 2,
                                    .witness = {},
                                    .reason = {}},
                                   {.condition = Condition::initial,
                                    .method = Method::conformal,
                                    .verdict = Verdict::passed,
                                    .samples = 250000,
                                    .epsilon = 1e-4,
                                    .beta = 5e-5,
                                    .attempt = 2,
                                    .witness = {},
                                    .reason = {}}};
  for (const char* words : {"confidence 1 - 0.0001", "attempt 2", "a copy of the file begins anew", "250000",
                            "seed 4", "epsilon = 0.0001", "does not prove that every motion is safe"})
    EXPECT_TRUE(says(record, words)) << words << ": " << guarantee_statement(record);
}

TEST(Statement, OfAnInvariantSetSaysWhetherTheMarginCoversFloat32) {
  RunRecord record = record_with(Guarantee::invariant);
  EXPECT_TRUE(says(record, "stays in it for ever"));
  EXPECT_TRUE(says(record, "No margin against disturbances was certified"));
  record.certificate.disturbance_margin = 0.02;
  record.certificate.float32_error = 0.001;
  EXPECT_TRUE(says(record, "|w| <= 1 mm/s (0.02 normalised)")) << guarantee_statement(record);
  EXPECT_TRUE(says(record, "this margin covers"));
  record.certificate.float32_error = 0.03;
  EXPECT_TRUE(says(record, "does NOT cover"));
}

TEST(Statement, OfProvedConditionsAloneDoesNotSpeakOfWholeMotions) {
  const RunRecord record = record_with(Guarantee::proved);
  EXPECT_FALSE(says(record, "stays in it for ever"));
  EXPECT_TRUE(says(record, "only while it stays inside"));
}

}  // namespace
}  // namespace s2nnds
