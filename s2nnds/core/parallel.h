// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace s2nnds {

// The threads that the library's loops share their work among; 0: all cores. The program's one setting: to be
// called before loops run, not during one. At the start: all cores. Throws Error if threads < 0.
void use_threads(int threads);
int thread_count();  // threads in use, >= 1

// body(index, worker) for every index in [0, count), in no particular order. Each index belongs to one
// thread, whose number worker < thread_count() stands for memory that only it uses. The first exception ends
// the loop and is rethrown. A loop within a loop runs in the thread that meets it. Threads that find no work
// sleep, so that processes which share the cores do not hold each other up.
void parallel_for(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t index, int worker)>& body);

// One piece of work beside the caller's, on the same threads as the loops: a thread that is free takes it up,
// and if none is before wait(), wait() does it. Loops within it run in its own thread.
class SideTask {
 public:
  SideTask();
  ~SideTask();  // waits; what the work threw is then lost
  SideTask(const SideTask&) = delete;
  SideTask& operator=(const SideTask&) = delete;

  void start(std::function<void()> work);  // after wait(), if something was started before
  void wait();                             // rethrows what the work threw; at once if nothing was started

 private:
  class Group;
  std::unique_ptr<Group> group_;
};

}  // namespace s2nnds
