// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <set>
#include <stdexcept>
#include <vector>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

class Parallel : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { use_threads(GetParam()); }
  void TearDown() override { use_threads(0); }
};

TEST_P(Parallel, VisitsEveryIndexOnceWithWorkersInRange) {
  EXPECT_EQ(thread_count(), GetParam());
  std::vector<std::atomic<int>> visits(1000);
  parallel_for(1000, [&](std::ptrdiff_t i, int worker) {
    ++visits[static_cast<std::size_t>(i)];
    EXPECT_GE(worker, 0);
    EXPECT_LT(worker, thread_count());
  });
  for (const auto& count : visits) EXPECT_EQ(count, 1);
}

// What a worker's number is for: no two threads have it at once, also where loops nest.
TEST_P(Parallel, NoTwoThreadsShareAWorkersNumber) {
  std::vector<std::atomic<int>> busy(static_cast<std::size_t>(thread_count()));
  std::atomic<bool> clash = false;
  parallel_for(200, [&](std::ptrdiff_t, int worker) {
    if (busy[static_cast<std::size_t>(worker)]++ != 0) clash = true;
    std::atomic<int> inner = 0;
    parallel_for(50, [&](std::ptrdiff_t, int) { ++inner; });
    EXPECT_EQ(inner, 50);
    --busy[static_cast<std::size_t>(worker)];
  });
  EXPECT_FALSE(clash);
}

TEST_P(Parallel, RethrowsAnException) {
  EXPECT_THROW(parallel_for(100,
                            [](std::ptrdiff_t i, int) {
                              if (i == 37) throw std::runtime_error("37");
                            }),
               std::runtime_error);
  int after = 0;
  parallel_for(1, [&](std::ptrdiff_t, int) { ++after; });
  EXPECT_EQ(after, 1);
}

TEST_P(Parallel, DoesNothingForNothing) {
  parallel_for(0, [](std::ptrdiff_t, int) { FAIL(); });
}

TEST_P(Parallel, SideTaskRunsBesideLoopsAndHasEndedAfterWait) {
  SideTask side;
  side.wait();  // nothing was started
  for (int round = 0; round < 50; ++round) {
    int drawn = 0;
    side.start([&] {
      parallel_for(10, [&](std::ptrdiff_t, int) { ++drawn; });  // in the task's own thread
    });
    std::atomic<int> looped = 0;
    parallel_for(20, [&](std::ptrdiff_t, int) { ++looped; });
    side.wait();
    EXPECT_EQ(drawn, 10);
    EXPECT_EQ(looped, 20);
  }
}

TEST_P(Parallel, SideTaskRethrowsAndCanBeUsedAgain) {
  SideTask side;
  side.start([] { throw std::runtime_error("side"); });
  EXPECT_THROW(side.wait(), std::runtime_error);
  bool done = false;
  side.start([&] { done = true; });
  side.wait();
  EXPECT_TRUE(done);
}

TEST_P(Parallel, SideTaskEndsBeforeItsOwner) {
  std::atomic<int> ended = 0;
  {
    SideTask side;
    side.start([&] { ++ended; });
  }
  {
    SideTask side;
    side.start([&] {
      ++ended;
      throw std::runtime_error("lost");
    });
  }
  EXPECT_EQ(ended, 2);
}

INSTANTIATE_TEST_SUITE_P(Threads, Parallel, testing::Values(1, 2, 3));

TEST(UseThreads, RefusesANegativeNumber) { EXPECT_THROW(use_threads(-1), Error); }

}  // namespace
}  // namespace s2nnds
