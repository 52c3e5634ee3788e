// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <memory>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

struct Pool {
  explicit Pool(int threads)
      : limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        arena(threads) {}
  tbb::global_control limit;
  tbb::task_arena arena;
};

std::unique_ptr<Pool>& pool() {
  static std::unique_ptr<Pool> current = std::make_unique<Pool>(tbb::info::default_concurrency());
  return current;
}

// A thread that waits for a loop within a loop could take up another index of the outer one, and with it the
// memory of a worker that it already is.
thread_local bool in_loop = false;
struct Inside {
  Inside() { in_loop = true; }
  ~Inside() { in_loop = before; }
  const bool before = in_loop;
};

}  // namespace

void use_threads(int threads) {
  check(threads >= 0, "threads: found {}, expected at least 0", threads);
  pool().reset();
  pool() = std::make_unique<Pool>(threads > 0 ? threads : tbb::info::default_concurrency());
}

int thread_count() { return pool()->arena.max_concurrency(); }

void parallel_for(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t, int)>& body) {
  if (in_loop || count <= 1 || thread_count() == 1) {
    for (std::ptrdiff_t i = 0; i < count; ++i)
      body(i, in_loop ? tbb::this_task_arena::current_thread_index() : 0);
    return;
  }
  pool()->arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::ptrdiff_t>(0, count, 1),
        [&](const tbb::blocked_range<std::ptrdiff_t>& range) {
          const Inside inside;
          for (std::ptrdiff_t i = range.begin(); i != range.end(); ++i)
            body(i, tbb::this_task_arena::current_thread_index());
        },
        tbb::simple_partitioner());
  });
}

class SideTask::Group : public tbb::task_group {};

SideTask::SideTask() : group_(std::make_unique<Group>()) {}

SideTask::~SideTask() {
  try {
    wait();
  } catch (...) {  // whoever leaves without wait() is on the way out with an exception already
  }
}

void SideTask::start(std::function<void()> work) {
  pool()->arena.execute([&] {
    group_->run([work = std::move(work)] {
      const Inside inside;
      work();
    });
  });
}

void SideTask::wait() {
  pool()->arena.execute([&] { group_->wait(); });
}

}  // namespace s2nnds
