// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/execution_options.h"

#include <gtest/gtest.h>

#include "s2nnds/core/check.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/config.h"
#include "s2nnds/runs/verification_run.h"
#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

ExecutionOptions read(const std::string& keys) {
  return parse_config("[execution]\n" + keys, "a test").execution;
}

Frame frame_in(const std::string& unit) {
  Frame frame;
  frame.unit = unit;
  frame.position_scale = 40.0;
  frame.velocity_scale = 20.0;  // two seconds a unit of time
  return frame;
}

TEST(ExecutionOptions, AreIdealUnlessSomethingIsAskedFor) {
  EXPECT_TRUE(ExecutionOptions().is_ideal());
  EXPECT_TRUE(read("").is_ideal());
  EXPECT_FALSE(read("speed = 2.0").is_ideal());
  EXPECT_FALSE(read("preset = \"arm_1khz\"").is_ideal());
}

TEST(ExecutionOptions, OfAPresetCanBeChangedKeyByKey) {
  const ExecutionOptions found = read("preset = \"arm_1khz\"\ndelay = 0.004");
  EXPECT_EQ(found.unit, "mm");
  EXPECT_EQ(found.period, 0.001);
  EXPECT_EQ(found.delay, 0.004);
  EXPECT_EQ(found.position_error, 1.0);
  EXPECT_EQ(to_toml(read(to_toml(found))), to_toml(found));
}

TEST(ExecutionOptions, BecomeNormalised) {
  const ExecutionOptions options = read(
      "period = 0.01\ndelay = 0.02\nlag = 0.04\nposition_error = 4.0\nvelocity_error = 5.0\n"
      "velocity_error_relative = 0.5\nspeed = 1.5");
  for (const auto& [unit, factor] : {std::pair{"mm", 1.0}, {"m", 1000.0}}) {
    ExecutionOptions chosen = options;
    chosen.unit = unit;
    const ExecutionModel model = execution_model(chosen, frame_in("mm"), 1e-6);
    EXPECT_NEAR(model.period, 0.005, 1e-12);
    EXPECT_NEAR(model.delay, 0.01, 1e-12);
    EXPECT_NEAR(model.lag, 0.02, 1e-12);
    EXPECT_NEAR(model.position_error, 0.1 * factor, 1e-9);
    EXPECT_NEAR(model.velocity_error, 0.25 * factor, 1e-9);
    EXPECT_GE(model.velocity_error, 0.25 * factor);
    EXPECT_EQ(model.velocity_error_relative, 0.5);
    EXPECT_EQ(model.field_error, 1e-6);
    EXPECT_EQ(model.least_speed, 1.5);
  }
  ExecutionOptions normalised = options;
  normalised.unit = "normalised";
  EXPECT_NEAR(execution_model(normalised, frame_in(""), 0.0).velocity_error, 5.0, 1e-12);
  ExecutionOptions enlarged = options;  // to three times its size: errors count a third
  enlarged.unit = "mm";
  enlarged.extent = 120.0;
  EXPECT_NEAR(execution_model(enlarged, frame_in("mm"), 0.0).position_error, 0.1 / 3.0, 1e-12);
  EXPECT_NEAR(execution_model(enlarged, frame_in("mm"), 0.0).velocity_error, 0.25 / 3.0, 1e-12);
  EXPECT_NEAR(execution_model(enlarged, frame_in("mm"), 0.0).delay, 0.01, 1e-12);
  EXPECT_NE(execution_in_words(enlarged, frame_in("mm")).find("3 times as large"), std::string::npos);
  ExecutionOptions metres = options;
  metres.unit = "m";
  EXPECT_THROW(execution_model(metres, frame_in("rad"), 0.0), Error);
}

TEST(ExecutionOptions, OutOfRangeAreRefused) {
  for (const char* keys :
       {"period = -0.001", "delay = -1.0", "lag = nan", "position_error = -1.0", "speed = 0.0",
        "extent = -1.0", "damping = -1.0", "convergence_radius = nan", "velocity_error_relative = 1.0",
        "preset = \"arm\"", "unit = \"inch\"", "delay = inf"}) {
    EXPECT_THROW(read(keys), Error) << keys;
  }
}

// A verified run of a hand-made system on shipped demonstrations.
RunRecord verified(const std::string& execution) {
  const std::string text = R"(
name = "executed"
[data]
source = "handwriting"
[problem]
frame = "normalised"
initial = { type = "ball", center = [0.3, -0.2], radius = 0.2 }
unsafe = { type = "ball", center = [1.05, 1.05], radius = 0.1 }
)" + execution;
  const PreparedRun setup = prepare(parse_config(text, "a test"), "");
  RunRecord record = new_record(setup, text);
  record.networks = simple_networks();
  verify(setup, record, Method::proof, setup.config.verification);
  if (!setup.config.execution.is_ideal() && record.certificate.execution.invariant)
    find_certified_speeds(setup, record);
  check_certificate(record, "a test");
  return record;
}

bool says(const RunRecord& record, const std::string& words) {
  return record.certificate.statement.find(words) != std::string::npos;
}

TEST(ExecutionCertificate, IsStatedBesideTheGuarantee) {
  const RunRecord ideal = verified("");
  ASSERT_EQ(ideal.certificate.guarantee, Guarantee::invariant) << ideal.certificate.statement;
  EXPECT_FALSE(says(ideal, "As a robot executes it"));
  EXPECT_EQ(ideal.certificate.scope.find("[execution]"), std::string::npos);

  const RunRecord covered =
      verified("[execution]\nunit = \"normalised\"\nvelocity_error = 0.1\nperiod = 0.001");
  EXPECT_TRUE(
      says(covered, "As a robot executes it (1 times f, commanded from a reading every 1 ms or sooner"))
      << covered.certificate.statement;
  EXPECT_TRUE(says(covered, "stays in it, with f evaluated in double or float32"));
  EXPECT_TRUE(says(covered, "times the demonstrated speed (up to"));
  EXPECT_TRUE(covered.certificate.execution.shielded);
  EXPECT_NE(covered.certificate.scope.find("[execution]"), std::string::npos);

  const RunRecord open = verified("[execution]\nunit = \"normalised\"\nvelocity_error = 5.0");
  EXPECT_EQ(open.certificate.guarantee, Guarantee::invariant);  // of the ideal motion
  EXPECT_TRUE(says(open, "the motion is NOT certified"));
  EXPECT_TRUE(says(open, "not about a robot's tracking error"));
}

// A push moves the arm by J / D: in the hand-made system {B < 0} is a rounded square.
TEST(ExecutionCertificate, SaysWhichPushesAreWithstood) {
  const RunRecord none = verified("");
  EXPECT_EQ(none.pushes.size(), 0);
  const RunRecord weak = verified("[execution]\ndamping = 20.0"),
                  strong = verified("[execution]\ndamping = 40.0");
  ASSERT_EQ(weak.pushes.cols(), 3);
  EXPECT_GE(weak.pushes.col(2).minCoeff(), 0.0);
  EXPECT_NEAR((strong.pushes.col(2) - 2.0 * weak.pushes.col(2)).norm(), 0.0, 1e-9);
  EXPECT_LE(weak.certificate.execution.least_push, weak.pushes.col(2).minCoeff());
  const double metres = metres_per_normalised({}, weak.data.frame);
  Eigen::Index middle = 0;
  weak.pushes.leftCols(2).rowwise().norm().minCoeff(&middle);  // the edge is about 0.8 away from there
  EXPECT_NEAR(weak.pushes(middle, 2), 20.0 * metres * 0.8, 20.0 * metres * 0.25);
  EXPECT_TRUE(says(weak, "an arm of damping 20 N s/m")) << weak.certificate.statement;
}

TEST(ExecutionCertificate, IsVoidForAnotherModel) {
  RunRecord record = verified("[execution]\nunit = \"normalised\"\nvelocity_error = 0.1");
  const std::string old = "velocity_error = 0.1";
  record.config.resolved.replace(record.config.resolved.find(old), old.size(), "velocity_error = 0.3");
  EXPECT_THROW(check_certificate(record, "a test"), Error);
}

// A counterexample that is found later ends what was proved besides the guarantee too.
TEST(ExecutionCertificate, FallsWithTheGuarantee) {
  RunRecord record =
      verified("[execution]\nunit = \"normalised\"\nvelocity_error = 0.1\nperiod = 0.001\ndamping = 20.0");
  ASSERT_TRUE(record.certificate.execution.invariant);
  ASSERT_GT(record.certificate.disturbance_margin, 0.0);
  ASSERT_GT(record.pushes.rows(), 0);
  ConditionVerdict found = record.certificate.conditions.front();
  found.method = Method::conformal;
  found.verdict = Verdict::failed;
  found.violations = 1;
  record.certificate.conditions.push_back(found);
  record.certificate.orientation.proved = true;
  record.certificate.orientation.bound = 1.0;
  const PreparedRun setup = prepare(record);
  seal_certificate(setup, record);
  VerificationOptions options = setup.config.verification;
  options.sampled.samples = 1000;
  verify(setup, record, Method::sampled, options);
  EXPECT_EQ(record.certificate.guarantee, Guarantee::none);
  EXPECT_EQ(record.certificate.disturbance_margin, 0.0);
  EXPECT_EQ(record.certificate.execution.model, "");
  EXPECT_FALSE(record.certificate.execution.invariant);
  EXPECT_FALSE(record.certificate.execution.shielded);
  EXPECT_FALSE(record.certificate.orientation.proved);
  EXPECT_EQ(record.certificate.orientation.bound, 0.0);
  EXPECT_NE(record.certificate.orientation.reason, "");
  EXPECT_EQ(record.pushes.size(), 0);
  EXPECT_NO_THROW(check_certificate(record, "a test"));
}

}  // namespace
}  // namespace s2nnds
