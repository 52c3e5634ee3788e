// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/child_process.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

TEST(ChildProcess, CarriesMoreThanPipesHoldBothWays) {
  std::string input(3'000'000, 'x');
  input += std::string("\0\n\xff", 3);
  const ChildResult result = run_child({"sh", "-c", "tee /dev/stderr; exit 7"}, input);
  EXPECT_TRUE(result.output == input);
  EXPECT_TRUE(result.errors == input);
  EXPECT_EQ(result.exit_code, 7);
}

TEST(ChildProcess, NeedNotReadItsInput) {
  const ChildResult result = run_child({"sh", "-c", "exec <&-; echo done"}, std::string(1'000'000, 'x'));
  EXPECT_EQ(result.output, "done\n");
  EXPECT_EQ(result.exit_code, 0);
}

TEST(ChildProcess, GetsItsArgumentsAsTheyAre) {
  const ChildResult result = run_child({"/usr/bin/printf", "%s|", "a b", "", "\"$HOME'\n"}, "");
  EXPECT_EQ(result.output, "a b||\"$HOME'\n|");
}

TEST(ChildProcess, ASignalIsAnExitCodeOfItsOwn) {
  EXPECT_EQ(run_child({"sh", "-c", "kill -9 $$"}, "").exit_code, 128 + 9);
}

TEST(RunningChild, TellsItsLinesAsTheyCome) {
  RunningChild child({"/bin/sh", "-c", "echo one >&2; echo out; printf 'two\\nthree' >&2; exit 5"});
  std::vector<std::string> lines;
  const ChildResult result = child.wait([&](const std::string& line) { lines.push_back(line); });
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "two", "three"}));
  EXPECT_EQ(result.output, "out\n");
  EXPECT_EQ(result.exit_code, 5);
}

TEST(RunningChild, IsStoppedWithAllThatItStarted) {
  RunningChild child({"/bin/sh", "-c", "sleep 1000 & echo $! >&2; wait"});
  pid_t grandchild = 0;
  const ChildResult result = child.wait([&](const std::string& line) {
    grandchild = std::stoi(line);
    child.stop();
  });
  EXPECT_EQ(result.exit_code, 128 + SIGKILL);
  for (int i = 0; i < 500 && ::kill(grandchild, 0) == 0; ++i) ::usleep(10'000);
  // Gone, or waiting for whoever takes over orphans.
  std::ifstream status("/proc/" + std::to_string(grandchild) + "/stat");
  std::string text;
  std::getline(status, text);
  EXPECT_TRUE(text.empty() || text.find(") Z") != std::string::npos) << text;
  child.stop();  // after its end: nothing
}

TEST(RunningChild, EndsWithItsObject) {
  { const RunningChild child({"/bin/sh", "-c", "sleep 1000"}); }
  EXPECT_THROW(RunningChild({"/nowhere/program"}), Error);
}

TEST(ChildProcess, SaysWhichProgramIsNotThere) {
  try {
    run_child({"/nowhere/python3", "-c", "pass"}, "");
    FAIL() << "expected an Error";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "/nowhere/python3: cannot start: No such file or directory");
  }
}

}  // namespace
}  // namespace s2nnds
