// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/safety_problem.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "s2nnds/core/check.h"
#include "s2nnds/data/frame.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/data/split.h"

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

std::string message(const ProblemOptions& options,
                    const std::vector<Demonstration>& demonstrations = lines()) {
  try {
    make_problem(options, demonstrations);
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
  ProblemOptions options;
  options.padding = 0.15;
  options.unsafe = disc(-0.5, 0.0, 0.2);
  const SafetyProblem problem = make_problem(options, lines());
  EXPECT_EQ(problem.dimension(), 2);
  EXPECT_EQ(problem.initial->describe(), "box lower (0.75, 0.35) upper (1, 0.75)");  // clipped at 1
  EXPECT_EQ(problem.unsafe->describe(), "ball centre (-0.5, 0) radius 0.2");
  options.initial = {.type = "ball_auto", .radius = 0.07};
  const SafetyProblem round = make_problem(options, lines());
  EXPECT_TRUE(round.initial->contains(Vector{{0.9, 0.61}}));
  EXPECT_FALSE(round.initial->contains(Vector{{0.9, 0.63}}));
}

TEST(SafetyProblem, TheWorkspaceMarginIsTheClosedOutsideOfTheContainedWorkspace) {
  ProblemOptions options;
  options.workspace = 2.0;
  options.containment = 0.75;
  const SafetyProblem problem = make_problem(options, lines());
  EXPECT_TRUE(problem.workspace_margin->contains(Vector{{1.5, 0.0}}));
  EXPECT_FALSE(problem.workspace_margin->contains(Vector{{1.4999, -1.4999}}));
  EXPECT_EQ(problem.workspace_margin->classify({Vector{{1.5, -2.0}}, Vector{{2.0, 2.0}}}), Location::inside);
  EXPECT_EQ(problem.workspace_margin->classify({Vector{{0.0, 0.0}}, Vector{{1.5, 1.0}}}), Location::unknown);
  EXPECT_EQ(problem.workspace_margin->classify({Vector{{0.0, 0.0}}, Vector{{1.4, 1.0}}}), Location::outside);
  options.containment = 0.0;
  EXPECT_EQ(make_problem(options, lines()).workspace_margin, nullptr);
}

TEST(SafetyProblem, DemonstrationsMayPassThroughTheObstacle) {
  ProblemOptions options;
  options.unsafe = disc(0.45, 0.275, 0.1);
  EXPECT_EQ(message(options), "");
}

TEST(SafetyProblem, WhatCannotBeSolvedIsRefused) {
  ProblemOptions options;
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
  ProblemOptions options;
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
  ProblemOptions options;
  options.workspace = 0.8;
  EXPECT_TRUE(has(message(options), "outside of the workspace")) << message(options);
  EXPECT_TRUE(has(message(options), "demonstration 0")) << message(options);
  EXPECT_TRUE(has(message({}, {}), "no demonstrations"));
  options.workspace = -1.0;
  EXPECT_TRUE(has(message(options), "workspace")) << message(options);
  options = {.containment = 1.5};
  EXPECT_TRUE(has(message(options), "containment")) << message(options);
  std::vector<Demonstration> broken = lines();
  broken[1].position(3, 0) = std::nan("");
  EXPECT_TRUE(has(message({}, broken), "demonstration 1")) << message({}, broken);
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
      const auto all = find_frame(set, setting.data.normalization).normalize(set.demonstrations);
      for (const auto& demonstrations : {all, select(all, split.train)}) {
        RegionFiles files(shared.string());
        EXPECT_NO_THROW(make_problem(setting.problem, demonstrations, files)) << entry.path();
      }
      // Those that come without data of their own keep clear of their obstacle.
      if (setting.data.source == "handwriting") {
        const SafetyProblem problem = make_problem(setting.problem, all);
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
