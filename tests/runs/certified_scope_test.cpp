// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/certified_scope.h"

#include <gtest/gtest.h>

#include <functional>

#include "s2nnds/core/check.h"
#include "s2nnds/runs/verification_run.h"
#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

// A verified run of a hand-made system on shipped demonstrations.
struct CertifiedScope : testing::Test {
  CertifiedScope() {
    const std::string text = R"(
name = "scope"
[data]
source = "handwriting"
[problem]
frame = "normalised"
unsafe = { type = "ball", center = [1.05, 1.05], radius = 0.1 }
)";
    const PreparedRun setup = prepare(parse_config(text, "a test"), "");
    record = new_record(setup, text);
    record.networks = simple_networks();
    VerificationOptions options = setup.config.verification;
    options.sampled.samples = 1000;
    verify(setup, record, Method::sampled, options);
  }

  std::string message(const std::function<void(RunRecord&)>& edit) const {
    RunRecord edited = record;
    edit(edited);
    try {
      check_certificate(edited, "run.h5");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  static void replace(std::string& text, const std::string& old, const std::string& with) {
    ASSERT_NE(text.find(old), std::string::npos) << text;
    text.replace(text.find(old), old.size(), with);
  }

  RunRecord record;
};

TEST_F(CertifiedScope, OfAnUntouchedRunIsAccepted) {
  EXPECT_FALSE(record.certificate.conditions.empty());
  EXPECT_NE(record.certificate.scope.find(record.certificate.weight_hash), std::string::npos);
  EXPECT_EQ(message([](RunRecord&) {}), "");
}

TEST_F(CertifiedScope, EveryEditOfWhatTheCertificateDependsOnIsNoticed) {
  const std::vector<std::pair<std::string, std::function<void(RunRecord&)>>> edits = {
      {"f negated", [](RunRecord& r) { r.networks.f.layers[0].weight *= -1.0; }},
      {"a bit of B", [](RunRecord& r) { r.networks.B.layers[0].weight(0, 0) *= 1.0 + 1e-15; }},
      {"obstacle", [](RunRecord& r) { replace(r.config.resolved, "radius = 0.1", "radius = 0.05"); }},
      {"band", [](RunRecord& r) { replace(r.config.resolved, "level_band = 0.01", "level_band = 0.001"); }},
      {"workspace", [](RunRecord& r) { replace(r.config.resolved, "workspace = 1.25", "workspace = 1.5"); }},
      {"containment",
       [](RunRecord& r) { replace(r.config.resolved, "containment = 0.985", "containment = 0.99"); }},
      {"initial set", [](RunRecord& r) { replace(r.config.resolved, "padding = 0.02", "padding = 0.01"); }},
      {"frame", [](RunRecord& r) { r.data.frame.position_scale *= 2.0; }},
      {"speed", [](RunRecord& r) { r.data.frame.velocity_scale *= 2.0; }},
      {"goal", [](RunRecord& r) { r.data.frame.goal[0] += 1.0; }},
      {"unit", [](RunRecord& r) { r.data.frame.unit = "km"; }},
      {"words", [](RunRecord& r) { r.problem.unsafe = "none"; }},
      {"band in words", [](RunRecord& r) { r.problem.level_band = 0.5; }},
      {"guarantee", [](RunRecord& r) { r.certificate.guarantee = Guarantee::invariant; }},
      {"margin", [](RunRecord& r) { r.certificate.disturbance_margin = 0.5; }},
      {"statement", [](RunRecord& r) { r.certificate.statement = "All is well."; }},
      {"a verdict", [](RunRecord& r) { r.certificate.conditions[0].verdict = Verdict::proved; }},
      {"no hash", [](RunRecord& r) { r.certificate.weight_hash = ""; }},
      {"no scope", [](RunRecord& r) { r.certificate.scope = r.certificate.seal = ""; }},
  };
  for (const auto& [what, edit] : edits) {
    const std::string found = message(edit);
    EXPECT_TRUE(found.starts_with("run.h5: found ")) << what << ": " << found;
    EXPECT_EQ(found.find('\n'), std::string::npos);
  }
}

// What is proved of a projected f is bound to its weights and its decay as all else is.
TEST_F(CertifiedScope, OfAProjectedFHoldsItsStability) {
  record.networks.V = {{{0.5 * Points::Identity(2, 2), {}, Activation::tanh}}, Head::diffeomorphism};
  record.networks.decay = 0.3;
  std::string& resolved = record.config.resolved;
  replace(resolved, "form = \"plain\"", "form = \"projected\"\ndecay = 0.3");
  replace(resolved, "form = \"squared_norm\"", "form = \"diffeomorphism\"");
  replace(resolved, "features = 16\n", "");
  replace(resolved, "quadratic = 0.05\n", "lipschitz = 0.95\n");
  replace(resolved, "method = \"proof\"", "method = \"sampled\"");
  const PreparedRun setup = prepare(record);
  VerificationOptions options = setup.config.verification;
  options.sampled.samples = 1000;
  verify(setup, record, Method::sampled, options);
  EXPECT_TRUE(record.certificate.stability.proved) << record.certificate.stability.reason;
  EXPECT_GE(record.certificate.stability.overshoot, 3.0);
  EXPECT_LT(record.certificate.stability.overshoot, 3.02);
  EXPECT_TRUE(record.certificate.statement.starts_with("Stability is proved: every motion"))
      << record.certificate.statement;
  EXPECT_EQ(message([](RunRecord&) {}), "");
  for (const auto& edit : std::vector<std::function<void(RunRecord&)>>{
           [](RunRecord& r) { r.networks.decay = 0.2; }, [](RunRecord& r) { r.networks.decay = 0.0; },
           [](RunRecord& r) { r.networks.V.layers[0].weight *= 3.0; },
           [](RunRecord& r) { r.certificate.stability.decay = 3.0; },
           [](RunRecord& r) { r.certificate.stability.overshoot = 1.0; },
           [](RunRecord& r) { r.certificate.stability.lipschitz = 0.1; }})
    EXPECT_TRUE(message(edit).starts_with("run.h5: found "));
  EXPECT_THROW(verify(setup, record, Method::proof, options), Error);
  record.networks.V.layers[0].weight *= 3.0;
  verify(setup, record, Method::sampled, options);
  EXPECT_FALSE(record.certificate.stability.proved);
  EXPECT_TRUE(record.certificate.statement.starts_with("Stability is NOT proved: "))
      << record.certificate.statement;
}

TEST_F(CertifiedScope, VerifyingAnEditedRunBeginsANewCertificate) {
  record.networks.f.layers[0].weight *= -1.0;
  const PreparedRun setup = prepare(record);
  record.certificate.guarantee = Guarantee::invariant;
  record.certificate.disturbance_margin = 0.5;
  VerificationOptions options = setup.config.verification;
  options.sampled.samples = 1000;
  verify(setup, record, Method::sampled, options);
  EXPECT_EQ(record.certificate.guarantee, Guarantee::none);
  EXPECT_EQ(record.certificate.disturbance_margin, 0.0);
  EXPECT_NO_THROW(check_certificate(record, "run.h5"));
}

// Else a weak method would seal what nobody has shown.
TEST_F(CertifiedScope, VerifyingAnEditedCertificateBeginsANewOne) {
  const std::vector<std::function<void(RunRecord&)>> edits = {
      [](RunRecord& run) { run.certificate.disturbance_margin = 0.5; },
      [](RunRecord& run) { run.certificate.execution.invariant = true; },
      [](RunRecord& run) { run.certificate.barrier_float32_error = 0.0; },
      [](RunRecord& run) { run.certificate.seal.clear(); },
      [](RunRecord& run) { run.problem.unsafe = "ball centre (9, 9) radius 0.1"; },
      [](RunRecord& run) {
        for (ConditionVerdict found : run.certificate.conditions) {
          found.method = Method::proof;
          found.verdict = Verdict::proved;
          run.certificate.conditions.push_back(found);
        }
        run.certificate.side = {true, true, true, true};
      }};
  const PreparedRun setup = prepare(record);
  VerificationOptions options = setup.config.verification;
  options.sampled.samples = 1000;
  const std::size_t conditions = record.certificate.conditions.size();
  for (std::size_t k = 0; k < edits.size(); ++k) {
    RunRecord edited = record;
    edits[k](edited);
    EXPECT_FALSE(is_intact(setup, edited)) << k;
    verify(setup, edited, Method::sampled, options);
    EXPECT_EQ(edited.certificate.guarantee, record.certificate.guarantee) << k;
    EXPECT_EQ(edited.certificate.disturbance_margin, 0.0) << k;
    EXPECT_FALSE(edited.certificate.execution.invariant) << k;
    EXPECT_GT(edited.certificate.barrier_float32_error, 0.0) << k;
    EXPECT_EQ(edited.certificate.conditions.size(), conditions) << k;
    EXPECT_EQ(edited.problem.unsafe, record.problem.unsafe) << k;
    EXPECT_NO_THROW(check_certificate(edited, "run.h5")) << k;
  }
}

}  // namespace
}  // namespace s2nnds
