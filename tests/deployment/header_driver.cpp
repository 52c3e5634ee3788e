// SPDX-License-Identifier: BSD-3-Clause
// Compiled by cpp_header_test with POLICY_HEADER and POLICY_NAMESPACE set: reads points [dimension] from
// stdin, writes velocity, lyapunov, barrier and safe of each to stdout as hexadecimal numbers, and last how
// often memory was allocated while they were computed.
#include <cstdio>
#include <vector>

#include "counted_allocations.h"

#include POLICY_HEADER

int main() {
  namespace policy = POLICY_NAMESPACE;
  constexpr int n = policy::dimension;
  static_assert(noexcept(policy::velocity(nullptr, nullptr))&& noexcept(policy::safe(nullptr)));
  std::vector<double> points;
  for (double value = 0.0; std::scanf("%lf", &value) == 1;) points.push_back(value);
  std::vector<double> results(points.size() / n * (n + 3));
  double* to = results.data();
  const long before = allocations;
  for (std::size_t i = 0; i + n <= points.size(); i += n, to += n + 3) {
    const double* x = points.data() + i;
    policy::velocity(x, to);
    to[n] = policy::lyapunov(x);
    to[n + 1] = policy::barrier(x);
    to[n + 2] = policy::safe(x) ? 1.0 : 0.0;
  }
  const long during = allocations - before;
  for (double value : results) std::printf("%a\n", value);
  std::printf("%ld\n", during);
  return before > 0 ? 0 : 1;  // the vectors above were counted, or the counter counts nothing
}
