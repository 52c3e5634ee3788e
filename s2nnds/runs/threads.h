// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

namespace s2nnds {

// How many threads each of those that compute in this process would use.
struct ThreadCounts {
  int loops = 1;            // the library's: networks, prover, rollouts
  std::optional<int> aten;  // tensors; none: a program without LibTorch
  std::optional<int> blas;  // OpenBLAS or BLIS behind them; none: no BLAS with threads of its own
};

// One setting for all: the library's loops get `threads` (0: all cores), ATen and the BLAS one, since what is
// left to them is too small to share, and their waiting threads would hold a core. Throws Error if `threads`
// is negative.
void set_threads(int threads);

// The settings as they are now.
ThreadCounts thread_counts();

}  // namespace s2nnds
