// SPDX-License-Identifier: BSD-3-Clause
#include "evaluated_policies.h"

#include "width_128.h"
#include "width_128_double.h"
#include "width_256.h"
#include "width_256_double.h"
#include "width_32.h"
#include "width_32_double.h"
#include "width_64.h"
#include "width_64_double.h"

namespace s2nnds::benchmarks {

Velocity float_policy(int width) {
  switch (width) {
    case 32:
      return policy_width_32::velocity;
    case 64:
      return policy_width_64::velocity;
    case 128:
      return policy_width_128::velocity;
    case 256:
      return policy_width_256::velocity;
    default:
      return nullptr;
  }
}

Velocity double_policy(int width) {
  switch (width) {
    case 32:
      return policy_width_32_double::velocity;
    case 64:
      return policy_width_64_double::velocity;
    case 128:
      return policy_width_128_double::velocity;
    case 256:
      return policy_width_256_double::velocity;
    default:
      return nullptr;
  }
}

double shielded_velocity(const double* x, const double* wanted, double* v) noexcept {
  return policy_width_64::shield(x, wanted, v);
}

}  // namespace s2nnds::benchmarks
