// SPDX-License-Identifier: BSD-3-Clause
// Compiled with POLICY_HEADER and POLICY_NAMESPACE set, of a policy with a range of scenes: reads x [dimension], p and rate
// [displaced_places] from stdin, writes velocity, lyapunov, barrier, safe and displaced of each to stdout as hexadecimal
// numbers, and last how often memory was allocated while they were computed.
#include <cstdio>
#include <vector>

#include "counted_allocations.h"

#include POLICY_HEADER

int main() {
  namespace policy = POLICY_NAMESPACE;
  constexpr int n = policy::dimension, m = policy::displaced_places;
  std::vector<double> numbers;
  for (double value = 0.0; std::scanf("%lf", &value) == 1;) numbers.push_back(value);
  std::vector<double> results(numbers.size() / (n + 2 * m) * (n + 4));
  double* to = results.data();
  const long before = allocations;
  for (std::size_t i = 0; i + n + 2 * m <= numbers.size(); i += n + 2 * m, to += n + 4) {
    const double *x = numbers.data() + i, *p = x + n, *rate = p + m;
    const bool certified = policy::velocity(x, p, rate, to);
    to[n] = policy::lyapunov(x, p);
    to[n + 1] = policy::barrier(x, p);
    to[n + 2] = policy::safe(x, p) ? 1.0 : 0.0;
    to[n + 3] = certified && policy::displaced(p) ? 1.0 : 0.0;
  }
  const long during = allocations - before;
  for (double value : results) std::printf("%a\n", value);
  std::printf("%ld\n", during);
  return before > 0 ? 0 : 1;  // the vectors above were counted, or the counter counts nothing
}
