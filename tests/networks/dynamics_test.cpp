// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/dynamics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

NetworkWeights random_stack(const std::vector<Eigen::Index>& sizes, double size, RandomStream& random) {
  NetworkWeights stack;
  for (std::size_t l = 0; l + 1 < sizes.size(); ++l) {
    const auto draw = [&] { return random.normal(); };
    const double scale = size / std::sqrt(static_cast<double>(sizes[l]));
    stack.layers.push_back({scale * Points::NullaryExpr(sizes[l + 1], sizes[l], draw),
                            Vector::NullaryExpr(sizes[l + 1], draw),
                            l + 2 < sizes.size() ? Activation::tanh : Activation::identity});
  }
  return stack;
}

// f steep, and V a diffeomorphism whose layers have spectral norms of some 0.9.
Networks projected(Eigen::Index n, double decay, RandomStream& random) {
  Networks networks;
  networks.f = random_stack({n, 40, n}, 3.0, random);
  networks.f.head = Head::zero_at_origin;
  networks.V = random_stack({n, 30, n}, 0.4, random);
  networks.V.head = Head::diffeomorphism;
  networks.B = random_stack({n, 8, 1}, 1.0, random);
  networks.decay = decay;
  return networks;
}

TEST(ValueAndGradient, IsThatOfTheDerivativesAlongTheAxes) {
  RandomStream random(1, "gradient");
  for (const Head head : {Head::plain, Head::squared_norm, Head::diffeomorphism}) {
    for (const Eigen::Index n : {1, 2, 7}) {
      NetworkWeights V = random_stack({n, 33, 20, head == Head::plain ? 1 : n}, 1.0, random);
      V.head = head;
      V.quadratic = head == Head::squared_norm ? 0.3 : 0.0;
      const Points x = Points::NullaryExpr(1000, n, [&] { return random.uniform(-2.0, 2.0); });
      Vector value;
      Points gradient;
      V.value_and_gradient(x, value, gradient);
      ASSERT_EQ(gradient.rows(), x.rows());
      EXPECT_LT((value - V.value(x).col(0)).cwiseAbs().maxCoeff(), 1e-12);
      for (Eigen::Index k = 0; k < n; ++k) {
        Points axis = Points::Zero(x.rows(), n), at, along;
        axis.col(k).setOnes();
        V.value_and_derivative(x, axis, at, along);
        EXPECT_LT((gradient.col(k) - along.col(0)).cwiseAbs().maxCoeff(), 1e-10) << to_string(head) << n;
      }
    }
  }
  Vector value;
  Points gradient;
  const NetworkWeights two = random_stack({2, 3, 2}, 1.0, random);
  EXPECT_THROW(two.value_and_gradient(Points::Zero(1, 2), value, gradient), Error);
}

TEST(Diffeomorphism, IsItsFormulaAndNeedsAsManyOutputs) {
  RandomStream random(2, "formula");
  NetworkWeights V = random_stack({3, 9, 3}, 0.3, random), layers = V;
  V.head = Head::diffeomorphism;
  const Points x = Points::NullaryExpr(50, 3, [&] { return random.normal(); });
  const Points phi = (x + layers.value(x)).rowwise() - layers.value(Points::Zero(1, 3)).row(0);
  EXPECT_LT((V.value(x).col(0) - phi.rowwise().squaredNorm()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(V.value(Points::Zero(1, 3))(0, 0), 0.0);
  V.quadratic = 0.1;
  EXPECT_THROW(V.check(), Error);
  V = random_stack({3, 9, 4}, 0.3, random);
  V.head = Head::diffeomorphism;
  EXPECT_THROW(V.check(), Error);
}

TEST(ProjectedVelocity, MakesVFallAsFastAsItMust) {
  constexpr double kDecay = 0.7;
  for (const Eigen::Index n : {2, 3, 6, 7}) {
    RandomStream random(3, "falls", static_cast<std::uint64_t>(n));
    const Networks networks = projected(n, kDecay, random);
    Points x = Points::NullaryExpr(25000, n, [&] { return random.normal(); });
    for (Eigen::Index i = 0; i < x.rows(); ++i) x.row(i) *= std::pow(10.0, random.uniform(-9.0, 1.0));
    const Points velocity = networks.velocity(x), free = networks.f.value(x);
    Points V, V_dot, free_dot;
    networks.V.value_and_derivative(x, velocity, V, V_dot);
    networks.V.value_and_derivative(x, free, V, free_dot);
    std::int64_t changed = 0;
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      // Between phi and N, whose numbers are of size 1, nine digits cancel next to the goal.
      const double rounding = 1e-12 * (1.0 + velocity.row(i).norm() / x.row(i).norm()) * V(i, 0) +
                              1e-14 * std::sqrt(V(i, 0)) * velocity.row(i).norm();
      EXPECT_LE(V_dot(i, 0), -kDecay * V(i, 0) + rounding) << x.row(i);
      if (free_dot(i, 0) <= -kDecay * V(i, 0) - rounding) {
        EXPECT_EQ(velocity.row(i), free.row(i));
      } else {
        ++changed;
        // The nearest one: the change is along the gradient, and no further than it must be.
        EXPECT_LE((velocity - free).row(i).norm(), free.row(i).norm() + kDecay * x.row(i).norm() * 10.0);
      }
    }
    EXPECT_GT(changed, 1000);
    EXPECT_LT(changed, 24000);
    EXPECT_TRUE((networks.velocity(Points::Zero(1, n)).array() == 0.0).all());
  }
}

TEST(ProjectedVelocity, IsFWithoutADecayAndIsInItsHash) {
  RandomStream random(4, "plain");
  Networks networks = projected(3, 0.5, random);
  const Points x = Points::NullaryExpr(500, 3, [&] { return random.normal(); });
  const std::string hash = weight_hash(networks);
  const Points velocity = networks.velocity(x);
  EXPECT_TRUE(networks.dynamics().is_projected());
  EXPECT_EQ(BasicDynamicsEvaluator<double>(networks.dynamics()).value(x), velocity);
  const Points quick = BasicDynamicsEvaluator<float>(networks).value(x);
  EXPECT_LT((quick - velocity).cwiseAbs().maxCoeff(), 1e-3);
  networks.decay = 0.6;
  EXPECT_NE(weight_hash(networks), hash);
  networks.decay = 0.0;
  EXPECT_NE(weight_hash(networks), hash);
  EXPECT_EQ(networks.velocity(x), networks.f.value(x));
  EXPECT_FALSE(networks.dynamics().is_projected());
}

TEST(ProjectedVelocity, LetsNotANumberThroughAndStandsTheSmallestNumbers) {
  double velocity[2] = {NAN, 1.0}, tiny[2] = {1e-200, 0.0}, still[2] = {0.0, 0.0};
  const double gradient[2] = {1.0, 0.0}, small[2] = {1e-170, 0.0}, none[2] = {0.0, 0.0};
  project_velocity(2, gradient, 1.0, 0.1, velocity);
  EXPECT_TRUE(std::isnan(velocity[0]));
  project_velocity(2, small, 1e-320, 0.1, tiny);
  EXPECT_TRUE(std::isfinite(tiny[0]));
  project_velocity(2, none, 0.0, 0.1, still);
  EXPECT_EQ(still[0], 0.0);
}

}  // namespace
}  // namespace s2nnds
