// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/stability.h"

#include <fmt/format.h>

#include <cmath>

#include "s2nnds/problem/interval.h"
#include "s2nnds/verification/lipschitz_bound.h"
#include "s2nnds/verification/standard_floating_point.h"

namespace s2nnds {

StabilityCertificate prove_stability(const Networks& networks) {
  const StandardFloatingPoint mode;
  StabilityCertificate found;
  if (!networks.is_projected()) return found;
  found.decay = networks.decay;
  networks.f.check();
  if (networks.V.head != Head::diffeomorphism) {
    found.reason = fmt::format("V has the head {}, expected diffeomorphism", to_string(networks.V.head));
  } else if (networks.f.head != Head::zero_at_origin) {
    found.reason = fmt::format("f has the head {}, expected zero_at_origin", to_string(networks.f.head));
  } else if (!std::isfinite(networks.decay)) {
    found.reason = "the decay is not finite";
  } else {
    found.lipschitz = lipschitz_bound(networks.V);
    if (found.lipschitz < 1.0) {
      const Interval bound(found.lipschitz);
      found.proved = true;
      found.overshoot = ((Interval(1.0) + bound) / (Interval(1.0) - bound)).upper;
    } else {
      found.reason = fmt::format(
          "the Lipschitz constant of phi(x) - x was bounded by {:.4g}, expected below 1", found.lipschitz);
      if (!std::isfinite(found.lipschitz)) found.lipschitz = 0.0;
    }
  }
  return found;
}

}  // namespace s2nnds
