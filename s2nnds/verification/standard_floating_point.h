// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cfenv>

namespace s2nnds {

// While it lives, this thread computes as the proofs assume: it rounds to nearest and underflows gradually, whatever
// its caller had set (flush-to-zero, another rounding mode). Afterwards the caller's mode is back.
class StandardFloatingPoint {
 public:
  StandardFloatingPoint() {  // glibc's default environment clears flush-to-zero and denormals-are-zero as well
    std::fegetenv(&callers_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~StandardFloatingPoint() { std::fesetenv(&callers_); }
  StandardFloatingPoint(const StandardFloatingPoint&) = delete;
  StandardFloatingPoint& operator=(const StandardFloatingPoint&) = delete;

 private:
  std::fenv_t callers_;
};

}  // namespace s2nnds
