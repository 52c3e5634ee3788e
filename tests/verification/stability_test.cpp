// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/stability.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>

#include "s2nnds/core/random.h"
#include "s2nnds/evaluation/rollout.h"
#include "s2nnds/networks/dynamics.h"
#include "s2nnds/verification/lipschitz_bound.h"

namespace s2nnds {
namespace {

Points random_matrix(Eigen::Index rows, Eigen::Index columns, RandomStream& random) {
  return Points::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

TEST(SpectralNormBound, IsAboveTheNormAndNear) {
  RandomStream random(1, "bound");
  for (const auto& [rows, columns] : {std::pair{1, 1}, {1, 9}, {7, 1}, {5, 5}, {64, 6}, {6, 64}, {64, 64}}) {
    for (const double size : {1e-120, 1e-3, 1.0, 1e100}) {
      const Points matrix = size * random_matrix(rows, columns, random);
      const double norm = Eigen::JacobiSVD<Eigen::MatrixXd>(matrix).singularValues()[0];
      const double bound = spectral_norm_bound(matrix);
      EXPECT_GE(bound, norm * (1.0 - 1e-14));
      EXPECT_LE(bound, norm * 1.0095) << rows << " " << columns << " " << size;
    }
  }
}

TEST(SpectralNormBound, KnowsWhatIsKnown) {
  RandomStream random(2, "known");
  EXPECT_EQ(spectral_norm_bound(Points::Zero(4, 3)), 0.0);
  EXPECT_NEAR(spectral_norm_bound((Points(1, 1) << -0.75).finished()), 0.75, 1e-12);
  // A matrix of ones has the norm sqrt(rows columns); a rotation has 1, and all its singular values count.
  EXPECT_NEAR(spectral_norm_bound(Points::Ones(4, 9)), 6.0, 1e-10);
  const Points q = Eigen::HouseholderQR<Eigen::MatrixXd>(random_matrix(32, 32, random)).householderQ() *
                   Eigen::MatrixXd::Identity(32, 32);
  EXPECT_GE(spectral_norm_bound(q), 1.0);
  EXPECT_LE(spectral_norm_bound(q), 1.0068);
  EXPECT_EQ(spectral_norm_bound(1e200 * Points::Ones(2, 2)), INFINITY);  // its Gram matrix overflows
}

Networks stable(Eigen::Index n, double lipschitz, RandomStream& random) {
  Networks networks;
  networks.f = {{{2.0 * random_matrix(20, n, random), random_matrix(20, 1, random).col(0), Activation::tanh},
                 {random_matrix(n, 20, random), {}, Activation::identity}},
                Head::zero_at_origin};
  networks.V = {{{random_matrix(20, n, random), random_matrix(20, 1, random).col(0), Activation::tanh},
                 {random_matrix(n, 20, random), {}, Activation::identity}},
                Head::diffeomorphism};
  networks.V.layers[1].weight *= lipschitz / lipschitz_bound(networks.V);
  networks.decay = 0.4;
  return networks;
}

TEST(Stability, IsProvedOfContractionsAndOfNothingElse) {
  RandomStream random(3, "proved");
  Networks networks = stable(6, 0.9, random);
  StabilityCertificate found = prove_stability(networks);
  EXPECT_TRUE(found.proved) << found.reason;
  EXPECT_NEAR(found.lipschitz, 0.9, 1e-6);
  EXPECT_NEAR(found.overshoot, 19.0, 1e-3);
  EXPECT_EQ(found.decay, 0.4);
  const auto refused = [&](const auto& change, const std::string& reason) {
    Networks other = networks;
    change(other);
    found = prove_stability(other);
    EXPECT_FALSE(found.proved) << reason;
    EXPECT_NE(found.reason.find(reason), std::string::npos) << found.reason;
  };
  refused([](Networks& n) { n.V.layers[0].weight *= 1.2; }, "Lipschitz constant");
  refused(
      [](Networks& n) {
        n.V.layers[0].activation = Activation::silu;
        n.V.layers[1].weight *= 1.05;
      },
      "Lipschitz constant");
  refused([](Networks& n) { n.V.head = Head::squared_norm; }, "squared_norm");
  refused([](Networks& n) { n.f.head = Head::plain; }, "zero_at_origin");
  refused([](Networks& n) { n.decay = INFINITY; }, "decay");
  networks.decay = 0.0;
  found = prove_stability(networks);
  EXPECT_FALSE(found.proved);
  EXPECT_EQ(found.reason, "");
}

// What is proved, seen: distances along motions from anywhere fall as they must, whatever f is.
TEST(Stability, HoldsAlongMotions) {
  RandomStream random(4, "motions");
  for (int trial = 0; trial < 5; ++trial) {
    const Networks networks = stable(7, 0.8, random);
    const StabilityCertificate found = prove_stability(networks);
    ASSERT_TRUE(found.proved);
    Points x = 5.0 * random_matrix(200, 7, random);
    const Vector start = x.rowwise().norm();
    constexpr double kStep = 2e-3;
    for (int step = 1; step <= 2000; ++step) {
      const Points middle = x + 0.5 * kStep * networks.velocity(x);
      x += kStep * networks.velocity(middle);
      if (step % 200 != 0) continue;
      const double share = found.overshoot * std::exp(-0.5 * found.decay * kStep * step) * 1.01;
      EXPECT_TRUE((x.rowwise().norm().array() <= share * start.array()).all()) << step;
    }
  }
}

}  // namespace
}  // namespace s2nnds
