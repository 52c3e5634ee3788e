#pragma once

#include <cstddef>
#include <functional>

namespace s2nnds {

// The threads that the library's loops share their work among; 0: all cores. The program's one setting: to be
// called before loops run, not during one. At the start: all cores.
void use_threads(int threads);
int thread_count();

// body(index, worker) for every index in [0, count), in no particular order. Each index belongs to one
// thread, whose number worker < thread_count() stands for memory that only it uses. The first exception ends
// the loop and is rethrown. A loop within a loop runs in the thread that meets it. Threads that find no work
// sleep, so that processes which share the cores do not hold each other up.
void parallel_for(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t index, int worker)>& body);

}  // namespace s2nnds
