// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "random_policy.h"
#include "s2nnds/core/check.h"
#include "tests/verification/exact_network.h"

namespace s2nnds {

// A policy whose barrier has both signs in the workspace.
inline Networks with_barrier(Networks networks, Activation activation, RandomStream& random) {
  const int n = static_cast<int>(networks.f.input_dimension());
  networks.B = random_stack({n, 16, 16, 1}, activation, true, false, random);
  networks.B.layers.back().bias -= networks.B.value(Points::Zero(1, n)).row(0).transpose();
  return networks;
}

// B at the position x [n], to 50 digits.
inline Exact exact_barrier(const Policy& policy, const Eigen::RowVectorXd& x) {
  ExactVector z;
  for (Eigen::Index d = 0; d < x.size(); ++d)
    z.push_back((Exact(x[d]) - policy.info.goal[static_cast<std::size_t>(d)]) / policy.info.position_scale);
  return exact_network(policy.networks.B, z, z).value.front();
}

// Positions [2 count, n] in the workspace, in pairs as close as doubles are: B <= 0 at one and B > 0 at the other.
inline Points boundary_positions(const Policy& policy, Eigen::Index count, RandomStream& random) {
  const Eigen::Index n = policy.info.dimension;
  const auto anywhere = [&] {
    Eigen::RowVectorXd x(n);
    for (Eigen::Index d = 0; d < n; ++d) {
      const auto at = static_cast<std::size_t>(d);
      x[d] =
          random.uniform(policy.info.workspace[at], policy.info.workspace[at + static_cast<std::size_t>(n)]);
    }
    return x;
  };
  Points found(2 * count, n);
  for (Eigen::Index i = 0, tries = 0; i < count;) {
    check(++tries < 1000 * count, "expected a barrier of both signs");
    Eigen::RowVectorXd inside = anywhere(), outside = anywhere();
    if (exact_barrier(policy, inside) > 0 || exact_barrier(policy, outside) <= 0) continue;
    for (int k = 0; k < 60; ++k) {
      const Eigen::RowVectorXd middle = 0.5 * (inside + outside);
      (exact_barrier(policy, middle) > 0 ? outside : inside) = middle;
    }
    found.row(2 * i) = inside;
    found.row(2 * i + 1) = outside;
    ++i;
  }
  return found;
}

}  // namespace s2nnds
