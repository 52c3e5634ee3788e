// SPDX-License-Identifier: BSD-3-Clause
// States (x, s) with a phase s, from demonstrations to a run file and what is said of it.
#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/deployment/policy.h"
#include "s2nnds/evaluation/safe_area.h"
#include "s2nnds/evaluation/trajectory_metrics.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/motion_report.h"
#include "s2nnds/runs/prepared_run.h"
#include "s2nnds/runs/scene.h"
#include "s2nnds/runs/statement.h"
#include "tests/problem/region_attack.h"
#include "tests/runs/temporary_directory.h"

namespace s2nnds {
namespace {

// Circles around (5, 3) m that end where they start, at (5.2, 3), without end speeds.
DemonstrationSet circles() {
  DemonstrationSet set{"circle", "m", {}};
  for (const double radius : {0.2, 0.21}) {
    Demonstration d{Vector::LinSpaced(201, 0, 3), Points(201, 2), {}};
    for (Eigen::Index i = 0; i < 201; ++i) {
      const double u = static_cast<double>(i) / 200, turn = 2 * M_PI * u * u * u * (10 + u * (6 * u - 15));
      d.position.row(i) << 5.2 - radius + radius * std::cos(turn), 3 + radius * std::sin(turn);
    }
    d.velocity = differentiate(d.time, d.position);
    set.demonstrations.push_back(d);
  }
  return set;
}

constexpr const char* kConfig =
    "name = \"circle\"\n[problem]\nunsafe = { type = \"ball\", center = [5.0, 3.0], radius = 0.05 }\n";

PreparedRun prepared(const std::vector<std::string>& settings = {}, const DemonstrationSet& set = circles()) {
  return prepare(parse_config(kConfig, "a test", settings), set, RegionFiles());
}

// f = -(x, s), and V and B that are some functions.
Networks some_networks() {
  Networks networks;
  networks.f.layers = {{-Points::Identity(3, 3), Vector(), Activation::identity}};
  networks.f.head = Head::zero_at_origin;
  networks.V.layers = {{Points::Identity(3, 3), Vector(), Activation::identity}};
  networks.V.head = Head::squared_norm;
  networks.V.quadratic = 0.1;
  networks.B.layers = {{Points{{1.0, 0.5, 0.25}}, Vector::Constant(1, -0.4), Activation::identity}};
  return networks;
}

TEST(PhaseRun, SetsAreThoseOfPlaces) {
  const PreparedRun setup = prepared();
  const SafetyProblem& problem = setup.problem;
  EXPECT_EQ(setup.data.dimension, 3);
  EXPECT_EQ(problem.dimension(), 3);
  EXPECT_EQ(problem.places(), 2);
  const double start = problem.phase_start;
  EXPECT_NEAR(start, 2 * M_PI * 0.205 / setup.data.frame.position_scale, 5e-3);  // the mean length
  EXPECT_DOUBLE_EQ(problem.workspace.lower[2], -0.25 * start);
  EXPECT_DOUBLE_EQ(problem.workspace.upper[2], 1.25 * start);
  EXPECT_DOUBLE_EQ(problem.workspace.upper[0], 1.25);
  EXPECT_TRUE(problem.contained.lower[2] > -0.25 * start && problem.contained.upper[2] < 1.25 * start);
  // The obstacle is there whatever the phase; motions start with it near its start.
  const Vector middle =
      (Vector{{5.0, 3.0}} - setup.data.frame.goal.head(2)) / setup.data.frame.position_scale;
  for (const double s : {-0.2, 0.0, 0.6, 1.2})
    EXPECT_TRUE(problem.unsafe->contains(Vector{{middle[0], middle[1], s * start}})) << s;
  EXPECT_TRUE(problem.initial->contains(Vector{{0.0, 0.0, start}}));
  EXPECT_FALSE(problem.initial->contains(Vector{{0.0, 0.0, 0.9 * start}}));
  EXPECT_FALSE(problem.initial->contains(Vector{{0.0, 0.0, 0.0}}));
  EXPECT_EQ(problem.written_unsafe.type, "extrusion");
  const PreparedRun bounded =
      prepared({"problem.bounds.lower=[4.5, 2.6]", "problem.bounds.upper=[5.4, 3.4]"});
  EXPECT_DOUBLE_EQ(bounded.problem.workspace.upper[2], 1.25 * start);
  EXPECT_NEAR(bounded.problem.workspace.upper[1], 0.4 / bounded.data.frame.position_scale, 1e-9);
  const PreparedRun normalised = prepared({"problem.frame=\"normalised\"", "problem.unsafe={type=\"none\"}"});
  EXPECT_TRUE(normalised.problem.initial->contains(Vector{{0.0, 0.0, start}}));
  EXPECT_EQ(normalised.problem.unsafe->describe(), "none");
  EXPECT_FALSE(prepared({"data.state=\"position\""}).problem.has_phase());
}

TEST(PhaseRun, EverythingComesBackFromTheFile) {
  const PreparedRun setup = prepared();
  RunRecord a = new_record(setup, kConfig);
  a.networks = some_networks();
  const TemporaryDirectory directory;
  save_run(directory.file("run.h5"), a);
  const RunRecord b = load_run(directory.file("run.h5"));
  EXPECT_EQ(b.data.frame.phase_start, a.data.frame.phase_start);
  EXPECT_EQ(b.data.demonstrations[1].position, a.data.demonstrations[1].position);
  const PreparedRun again = prepare(b);
  EXPECT_EQ(certified_scope(again, b), certified_scope(setup, a));
  EXPECT_NE(certified_scope(setup, a).find("extrusion"), std::string::npos);
  RunRecord other = b;  // a start that the certificate does not speak of
  other.data.frame.phase_start *= 0.9;
  EXPECT_NE(certified_scope(prepare(other), other), certified_scope(setup, a));
  other.data.frame.phase_start = -1.0;
  EXPECT_THROW(check_record(other), Error);
}

TEST(PhaseRun, IsSaidInTheStatementAndInExports) {
  const PreparedRun setup = prepared();
  RunRecord record = new_record(setup, kConfig);
  record.networks = some_networks();
  record.certificate.guarantee = Guarantee::invariant;
  const std::string text = guarantee_statement(record);
  for (const char* words :
       {"every motion (x, s)' = f(x, s)", "s a number that the controller starts at 1.288 m",
        "s' = f_s(x, s)", "whatever s is", "whatever the last coordinate"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " in: " << text;
  const PolicyInfo info = policy_of(record).info;
  EXPECT_EQ(info.phase_start, setup.data.frame.phase_start);
  EXPECT_EQ(info.dimension, 3);
  bool visited = false;
  info.visit(
      [&](const std::string& name, const auto&, const char*) { visited = visited || name == "phase_start"; });
  EXPECT_TRUE(visited);
  record = new_record(prepared({"data.state=\"position\""}), kConfig);
  record.certificate.guarantee = Guarantee::invariant;
  EXPECT_EQ(guarantee_statement(record).find("(x, s)"), std::string::npos);
}

// Two fields that differ in s' alone.
TEST(PhaseRun, MotionsAreJudgedByTheirPlaces) {
  const PreparedRun setup = prepared();
  NetworkWeights one = some_networks().f, other = one;
  other.layers[0].weight(2, 2) = -3.0;
  const std::vector<Demonstration> shown = setup.train();
  const MotionErrors a = motion_errors(one, shown, {}, 2), b = motion_errors(other, shown, {}, 2);
  EXPECT_EQ(a.mse, b.mse);
  EXPECT_EQ(a.sd, b.sd);
  EXPECT_NEAR(a.dtw, b.dtw, 1e-4);
  EXPECT_NE(motion_errors(one, shown).mse, motion_errors(other, shown).mse);
  EXPECT_GT(std::abs(motion_errors(one, shown).dtw - motion_errors(other, shown).dtw), 1e-2);
  // Areas are those of places from which motions start.
  const SafeArea area = measure_safe_area(some_networks().f, some_networks().B, setup.problem, 100);
  // x + y / 2 <= 0.4 - s / 4, of 6.25
  EXPECT_NEAR(area.safe_area, 3.125 + 2.5 * (0.4 - 0.25 * setup.problem.phase_start), 0.01);
  EXPECT_LE(area.true_safe_area, 6.25);
}

TEST(PhaseRun, HasNoExecutionModel) {
  expect_message(message_of([] { prepared({"execution.period=0.001"}); }), "whose states have a phase");
  expect_message(message_of([] { prepared({"execution.damping=20.0"}); }), "whose states have a phase");
}

}  // namespace
}  // namespace s2nnds
