#pragma once

#include <optional>

namespace s2nnds {

// How many threads each of those that compute in this process would use.
struct ThreadCounts {
  int openmp = 1;           // the networks' fused engine, the prover, rollouts
  int aten = 1;             // tensors
  std::optional<int> blas;  // OpenBLAS or BLIS behind them; none: a BLAS without threads of its own
};

// One setting for all of them, so that no two pools compete for the cores. 0: as many as OpenMP likes
// (OMP_NUM_THREADS, else all cores). Throws Error if `threads` is negative.
void set_threads(int threads);
ThreadCounts thread_counts();

}  // namespace s2nnds
