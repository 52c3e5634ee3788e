// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/networks/network_weights.h"
#include "s2nnds/verification/certificate.h"

namespace s2nnds {

// Whether every motion of the networks' velocity, from any state, converges to the goal, by construction: f is projected
// on the directions along which V falls at least as fast as e^(-kappa t), and V = |phi|^2, phi(x) = x + N(x) - N(0), has
// N with a Lipschitz constant below 1, which is proved here. The argument is in verification/README.md. Nothing is found
// of networks that are not projected.
StabilityCertificate prove_stability(const Networks& networks);

}  // namespace s2nnds
