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

INSTANTIATE_TEST_SUITE_P(Threads, Parallel, testing::Values(1, 2, 3));

TEST(UseThreads, RefusesANegativeNumber) { EXPECT_THROW(use_threads(-1), Error); }

}  // namespace
}  // namespace s2nnds
