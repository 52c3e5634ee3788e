// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/platform.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

namespace s2nnds {
namespace {

TEST(Platform, NamesTheRunningProgram) {
  const std::filesystem::path path = executable_path();
  EXPECT_TRUE(path.is_absolute());
  EXPECT_TRUE(std::filesystem::is_regular_file(path));
  EXPECT_EQ(path.filename(), "core_test");
}

TEST(Platform, HasACore) { EXPECT_GE(available_cores(), 1); }

// A pending signal is taken at once and only once; without one the wait ends in time.
TEST(Platform, WaitsForASignal) {
  sigset_t signals, before;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  ASSERT_EQ(pthread_sigmask(SIG_BLOCK, &signals, &before), 0);
  raise(SIGTERM);
  EXPECT_EQ(wait_for_signal(signals, 10.0), SIGTERM);
  EXPECT_EQ(wait_for_signal(signals, 0.01), 0);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

#if defined(__linux__)
// Once the grandchild has asked for it, the child is killed; then the grandchild's end of the pipe closes too.
TEST(Platform, AProcessEndsWithItsParent) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    if (fork() == 0) {
      end_with_parent();
      if (write(ends[1], "r", 1) != 1) _exit(1);
    } else {
      close(ends[1]);
    }
    while (true) pause();
  }
  close(ends[1]);
  char byte = 0;
  EXPECT_EQ(read(ends[0], &byte, 1), 1);
  kill(child, SIGKILL);
  EXPECT_EQ(read(ends[0], &byte, 1), 0);
  close(ends[0]);
  waitpid(child, nullptr, 0);
}
#endif

}  // namespace
}  // namespace s2nnds
