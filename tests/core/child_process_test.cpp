// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/child_process.h"

#include <gtest/gtest.h>

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
