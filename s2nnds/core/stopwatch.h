// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

namespace s2nnds {

// Measures time from when it was made, by a clock that never goes back.
class Stopwatch {
 public:
  // Seconds since it was made.
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace s2nnds
