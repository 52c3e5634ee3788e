// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/safety_problem.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "s2nnds/core/check.h"
#include "s2nnds/data/frame.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/data/split.h"
#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {
namespace {

// Straight lines to the origin.
std::vector<Demonstration> lines() {
  std::vector<Demonstration> all;
  for (double y : {0.5, 0.6}) {
    Demonstration d;
    d.time = Vector::LinSpaced(11, 0.0, 1.0);
    d.position = (1.0 - d.time.array()).matrix() * Eigen::RowVector2d(0.9, y);
    d.velocity = Points::Ones(11, 1) * Eigen::RowVector2d(-0.9, -y);
    all.push_back(d);
  }
  return all;
}

// In the data of the tests one normalised unit is 400 mm, and the goal is at (500, 200) mm.
Frame millimetres() {
  Frame frame;
  frame.unit = "mm";
  frame.goal = Vector{{500.0, 200.0}};
  frame.position_scale = 400.0;
  return frame;
}

ProblemOptions normalised() {
  ProblemOptions options;
  options.frame = "normalised";
  return options;
}

std::string message(const ProblemOptions& options,
                    const std::vector<Demonstration>& demonstrations = lines()) {
  try {
    make_problem(options, demonstrations, millimetres());
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos && text.find('\n') == std::string::npos;
}

RegionOptions disc(double x, double y, double radius) {
  return {.type = "ball", .center = {x, y}, .radius = radius};
}

TEST(SafetyProblem, AutomaticInitialSets) {
  ProblemOptions options = normalised();
  options.padding = 0.15;
  options.unsafe = disc(-0.5, 0.0, 0.2);
  const SafetyProblem problem = make_problem(options, lines(), millimetres());
  EXPECT_EQ(problem.dimension(), 2);
  EXPECT_EQ(problem.initial->describe(), "box lower (0.75, 0.35) upper (1, 0.75)");  // clipped at 1
  EXPECT_EQ(problem.unsafe->describe(), "ball centre (-0.5, 0) radius 0.2");
  options.initial = {.type = "ball_auto", .radius = 0.07};
  const SafetyProblem round = make_problem(options, lines(), millimetres());
  EXPECT_TRUE(round.initial->contains(Vector{{0.9, 0.61}}));
  EXPECT_FALSE(round.initial->contains(Vector{{0.9, 0.63}}));
}

TEST(SafetyProblem, TheWorkspaceMarginIsTheClosedOutsideOfTheContainedWorkspace) {
  ProblemOptions options = normalised();
  options.workspace = 2.0;
  options.containment = 0.75;
  const SafetyProblem problem = make_problem(options, lines(), millimetres());
  EXPECT_TRUE(problem.workspace_margin->contains(Vector{{1.5, 0.0}}));
  EXPECT_FALSE(problem.workspace_margin->contains(Vector{{1.4999, -1.4999}}));
  EXPECT_EQ(problem.workspace_margin->classify({Vector{{1.5, -2.0}}, Vector{{2.0, 2.0}}}), Location::inside);
  EXPECT_EQ(problem.workspace_margin->classify({Vector{{0.0, 0.0}}, Vector{{1.5, 1.0}}}), Location::unknown);
  EXPECT_EQ(problem.workspace_margin->classify({Vector{{0.0, 0.0}}, Vector{{1.4, 1.0}}}), Location::outside);
  options.containment = 0.0;
  EXPECT_EQ(make_problem(options, lines(), millimetres()).workspace_margin, nullptr);
}

TEST(SafetyProblem, DemonstrationsMayPassThroughTheObstacle) {
  ProblemOptions options = normalised();
  options.unsafe = disc(0.45, 0.275, 0.1);
  EXPECT_EQ(message(options), "");
}

TEST(SafetyProblem, WhatCannotBeSolvedIsRefused) {
  ProblemOptions options = normalised();
  options.unsafe = disc(0.1, 0.0, 0.1 + 1e-9);
  EXPECT_TRUE(has(message(options), "covers the goal")) << message(options);
  options.unsafe = disc(0.9, 0.3, 0.185);
  EXPECT_TRUE(has(message(options), "meets the unsafe set")) << message(options);
  options.unsafe = disc(0.9, 0.3, 0.175);  // X0 begins at y = 0.48
  EXPECT_EQ(message(options), "");
  options.unsafe = disc(3.0, 3.0, 0.1);
  EXPECT_TRUE(has(message(options), "no points in the workspace")) << message(options);
  options.unsafe = {.type = "expression", .level = "log(x + 1)"};
  EXPECT_TRUE(has(message(options), "not a number")) << message(options);
  options.unsafe = {.type = "ball", .center = {0.0, 0.0, 0.0}, .radius = 0.1};
  EXPECT_TRUE(has(message(options), "problem.unsafe: ball: center has 3 numbers, expected 2"))
      << message(options);
  options.unsafe = {.type = "auto"};
  EXPECT_TRUE(has(message(options), "problem.unsafe")) << message(options);
}

TEST(SafetyProblem, BadInitialSetsAreRefused) {
  ProblemOptions options = normalised();
  options.initial = disc(1.1, 0.0, 0.2);
  EXPECT_TRUE(has(message(options), "outside of the contained workspace")) << message(options);
  options.containment = 0.0;
  EXPECT_TRUE(has(message(options), "outside of the workspace")) << message(options);
  options.initial = {.type = "halfspace", .normal = {1.0, 0.0}, .offset = -0.5};
  EXPECT_TRUE(has(message(options), "outside of the workspace")) << message(options);
  options.initial = {.type = "none"};
  EXPECT_TRUE(has(message(options), "empty")) << message(options);
  options.initial = {.type = "auto"};
  options.padding = 0.0;
  EXPECT_TRUE(has(message(options), "no volume")) << message(options);
}

TEST(SafetyProblem, BadDemonstrationsAndOptionsAreRefused) {
  ProblemOptions options = normalised();
  options.workspace = 0.8;
  EXPECT_TRUE(has(message(options), "outside of the workspace")) << message(options);
  EXPECT_TRUE(has(message(options), "demonstration 0")) << message(options);
  EXPECT_TRUE(has(message(normalised(), {}), "no demonstrations"));
  options.workspace = -1.0;
  EXPECT_TRUE(has(message(options), "workspace")) << message(options);
  options.workspace = 1.25;
  options.containment = 1.5;
  EXPECT_TRUE(has(message(options), "containment")) << message(options);
  std::vector<Demonstration> broken = lines();
  broken[1].position(3, 0) = std::nan("");
  EXPECT_TRUE(has(message(normalised(), broken), "demonstration 1")) << message(normalised(), broken);
}

// What is written in the data's unit is the same problem as what is written normalised.
TEST(SafetyProblem, TheDataFrameIsTheSameProblem) {
  ProblemOptions written, inner = normalised();
  written.unsafe = disc(300.0, 400.0, 40.0);
  inner.unsafe = disc(-0.5, 0.5, 0.1);
  written.padding = inner.padding = 0.05;
  const SafetyProblem a = make_problem(written, lines(), millimetres());
  const SafetyProblem b = make_problem(inner, lines(), millimetres());
  EXPECT_EQ(a.unsafe->describe(), "ball centre (300, 400) radius 40");
  EXPECT_EQ(a.initial->describe(), "box lower (840, 380) upper (880, 460)");
  EXPECT_EQ(a.workspace.lower, b.workspace.lower);
  EXPECT_EQ(a.workspace_margin->describe(), b.workspace_margin->describe());
  RandomStream random(1, "frames");
  const Points x = uniform_points(a.workspace, 1000, random);
  EXPECT_LT((a.unsafe->level(x) - b.unsafe->level(x)).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT((a.initial->level(x) - b.initial->level(x)).cwiseAbs().maxCoeff(), 1e-13);
  written.unsafe = {.type = "none"};
  EXPECT_EQ(make_problem(written, lines(), millimetres()).unsafe->describe(), "none");
  written.initial = {.type = "ball_auto", .radius = 20.0};
  const SafetyProblem round = make_problem(written, lines(), millimetres());
  EXPECT_EQ(round.initial->describe(), "ball centre (860, 420) radius 20");
  EXPECT_TRUE(round.initial->contains(Vector{{0.9, 0.59}}));
  EXPECT_FALSE(round.initial->contains(Vector{{0.9, 0.61}}));
}

TEST(SafetyProblem, BoundsAreAWorkspaceOfTheirOwn) {
  ProblemOptions options;
  options.unsafe = disc(300.0, 300.0, 40.0);
  options.bounds = {.lower = {100.0, 180.0}, .upper = {900.0, 460.0}};
  const SafetyProblem problem = make_problem(options, lines(), millimetres());
  EXPECT_TRUE(problem.workspace.lower.isApprox(Vector{{-1.0, -0.05}}, 1e-12));
  EXPECT_TRUE(problem.workspace.upper.isApprox(Vector{{1.0, 0.65}}, 1e-12));
  // Never smaller than what was written.
  EXPECT_LE(problem.workspace.lower[1], -0.05);
  EXPECT_GE(problem.workspace.upper[1], 0.65);
  // As wide on every side of an axis: 0.75 % of the box.
  EXPECT_TRUE(problem.workspace_margin->contains(Vector{{0.0, -0.05 + 0.0052}}));
  EXPECT_FALSE(problem.workspace_margin->contains(Vector{{0.0, -0.05 + 0.0053}}));
  EXPECT_TRUE(problem.workspace_margin->contains(Vector{{-0.99, 0.0}}));
  options.bounds.upper = {900.0, 420.0};
  EXPECT_TRUE(has(message(options), "demonstration 1 is at (860, 440) mm at sample 0")) << message(options);
  EXPECT_TRUE(has(message(options), "within (100, 180) mm to (900, 420) mm")) << message(options);
  options.bounds.lower = {100.0, 200.0};
  EXPECT_TRUE(has(message(options), "expected the goal inside")) << message(options);
  options.bounds.lower = {950.0, 0.0};
  EXPECT_TRUE(has(message(options), "expected lower < upper")) << message(options);
  options.bounds.lower = {100.0};
  EXPECT_TRUE(has(message(options), "problem.bounds.lower: found 1 numbers, expected 2")) << message(options);
  options.bounds.lower = {100.0, -INFINITY};
  EXPECT_TRUE(has(message(options), "expected finite numbers")) << message(options);
}

TEST(SafetyProblem, MessagesSpeakOfTheDatasUnit) {
  ProblemOptions options;
  options.unsafe = disc(3000.0, 400.0, 40.0);
  EXPECT_TRUE(has(message(options), "no points in the workspace, (0, -300) mm to (1000, 700) mm"))
      << message(options);
  EXPECT_TRUE(has(message(options), "the goal is at (500, 200) mm")) << message(options);
  options.unsafe = disc(510.0, 200.0, 40.0);
  EXPECT_TRUE(has(message(options), "covers the goal, at (500, 200) mm")) << message(options);
  options.unsafe = {.type = "none"};
  options.initial = disc(950.0, 200.0, 50.0);
  EXPECT_TRUE(has(message(options), "expected it within (7.5, -292.5) mm to (992.5, 692.5) mm"))
      << message(options);
  options.frame = "robot";
  EXPECT_TRUE(has(message(options), "frame: expected one of data, normalised")) << message(options);
}

TEST(SafetyProblem, OptionsMakeTheRoundTrip) {
  ProblemOptions options;
  read_toml(
      "workspace = 1.5\ncontainment = 0\npadding = 0.1\ninitial = {type = \"ball_auto\", radius = 0.2}\n"
      "unsafe = {type = \"complement\", of = [{type = \"box\", lower = [-1, -inf], upper = [1, inf]}]}",
      "test", options);
  ProblemOptions again;
  read_toml(to_toml(options), "again", again);
  EXPECT_EQ(again.workspace, 1.5);
  EXPECT_EQ(again.containment, 0.0);
  EXPECT_EQ(again.initial.radius, 0.2);
  EXPECT_EQ(again.unsafe.of.at(0).upper, options.unsafe.of.at(0).upper);
  EXPECT_EQ(to_toml(again), to_toml(options));
}

// The part of a configuration that says what is learnt and where.
struct Setting {
  std::string name;
  DataOptions data;
  ProblemOptions problem;
  void visit(FieldVisitor& v) {
    v.field("name", name);
    v.group("data", data);
    v.group("problem", problem);
  }
};

TEST(SafetyProblem, TheShippedConfigurationsAreSound) {
  const std::filesystem::path shared = S2NNDS_SHARED_DATA;
  int skipped = 0, checked = 0;
  for (const char* folder : {"lasa", "abc_ds", "other", "handwriting"}) {
    const auto path = std::filesystem::path(S2NNDS_SOURCE_DIR) / "experiments/configs" / folder;
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      std::stringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      Setting setting;
      read_toml(text.str(), entry.path().string(), setting);
      if (setting.data.source != "handwriting" && !std::filesystem::exists(shared / setting.data.file)) {
        ++skipped;
        continue;
      }
      const DemonstrationSet set = read_demonstrations(setting.data, shared.string());
      const auto split = split_demonstrations(set.demonstrations.size(), setting.data.test);
      const Frame frame = find_frame(set, setting.data.normalization, setting.data.goal);
      const auto all = frame.normalize(set.demonstrations);
      for (const auto& demonstrations : {all, select(all, split.train)}) {
        RegionFiles files(shared.string());
        EXPECT_NO_THROW(make_problem(setting.problem, demonstrations, frame, files)) << entry.path();
      }
      // Those that come without data of their own keep clear of their obstacle.
      if (setting.data.source == "handwriting") {
        const SafetyProblem problem = make_problem(setting.problem, all, frame);
        EXPECT_GT(problem.unsafe->level(stack_positions(all)).minCoeff(), 0.08) << entry.path();
      }
      ++checked;
    }
  }
  EXPECT_GE(checked + skipped, 21);
  if (skipped > 0) GTEST_SKIP() << skipped << " configurations need data that is not there: " << shared;
}

}  // namespace
}  // namespace s2nnds
