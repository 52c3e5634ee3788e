// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/threads.h"

#include <dlfcn.h>

#include "s2nnds/core/parallel.h"
#include "s2nnds/runs/libtorch.h"

namespace s2nnds {
namespace {

// Which BLAS stands behind libblas.so.3 is the administrator's choice, so it is asked for by name at run
// time.
template <typename Function>
Function* find_function(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_DEFAULT, name));
}

}  // namespace

void set_threads(int threads) {
  use_threads(threads);
  set_tensor_threads(1);
  if (auto* set = find_function<void(int)>("openblas_set_num_threads")) set(1);
  if (auto* set = find_function<void(long)>("bli_thread_set_num_threads")) set(1);
}

ThreadCounts thread_counts() {
  ThreadCounts counts{thread_count(), tensor_threads(), {}};
  if (auto* get = find_function<int()>("openblas_get_num_threads")) counts.blas = get();
  if (auto* get = find_function<long()>("bli_thread_get_num_threads")) counts.blas = static_cast<int>(get());
  return counts;
}

}  // namespace s2nnds
