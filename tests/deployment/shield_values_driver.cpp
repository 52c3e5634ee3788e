// SPDX-License-Identifier: BSD-3-Clause
// Compiled by tests/program/robot_test.py with POLICY_HEADER and POLICY_NAMESPACE set: reads readings and wanted
// velocities [2 dimension] from stdin, writes the shield's velocity [dimension] and change of each to stdout.
#include <cstdio>

#include POLICY_HEADER

int main() {
  constexpr int n = POLICY_NAMESPACE::dimension;
  double row[2 * n], v[n];
  for (int k = 0; std::scanf("%lf", &row[k]) == 1;) {
    if (++k < 2 * n) continue;
    k = 0;
    const double change = POLICY_NAMESPACE::shield(row, row + n, v);
    for (const double value : v) std::printf("%.17g ", value);
    std::printf("%.17g\n", change);
  }
  return 0;
}
