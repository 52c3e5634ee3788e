// SPDX-License-Identifier: BSD-3-Clause
// Compiled by pose_policy_test with POLICY_HEADER and POLICY_NAMESPACE set: reads positions [dimension] and orientations [4]
// from stdin (with DISPLACED also displacements), writes velocity and angular velocity of each to stdout.
#include <cstdio>

#include POLICY_HEADER

int main() {
  namespace policy = POLICY_NAMESPACE;
  constexpr int n = policy::dimension;
  static_assert(noexcept(policy::velocity(nullptr, nullptr, nullptr, nullptr)));
#ifdef DISPLACED
  double state[n + 4 + policy::displaced_places], v[n], omega[3];
#else
  double state[n + 4], v[n], omega[3];
#endif
  for (;;) {
    for (double& value : state) {
      if (std::scanf("%lf", &value) != 1) return 0;
    }
#ifdef DISPLACED
    constexpr double rest[policy::displaced_places] = {};
    if (!policy::velocity(state, state + n, state + n + 4, rest, v, omega)) return 1;
#else
    policy::velocity(state, state + n, v, omega);
#endif
    for (double value : v) std::printf("%.17g\n", value);
    for (double value : omega) std::printf("%.17g\n", value);
  }
}
