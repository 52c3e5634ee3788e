// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/rounding_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "tests/verification/exact_network.h"

namespace s2nnds {
namespace {

Eigen::VectorXf in_float32(const NetworkWeights& stack, Eigen::VectorXf x) {
  for (const Layer& layer : stack.layers) {
    Eigen::VectorXf z = Eigen::VectorXf::Zero(layer.weight.rows());
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      for (Eigen::Index k = 0; k < layer.weight.cols(); ++k)
        z(i) += static_cast<float>(layer.weight(i, k)) * x(k);
      z(i) += static_cast<float>(layer.bias(i));
      if (layer.activation == Activation::tanh) z(i) = std::tanh(z(i));
      if (layer.activation == Activation::elu) z(i) = z(i) > 0.0F ? z(i) : std::expm1(z(i));
    }
    x = z;
  }
  return x;
}

TEST(Float32Error, BoundsTheErrorWithoutLosingSight) {
  RandomStream random(1, "float32");
  for (Activation activation : {Activation::tanh, Activation::elu}) {
    const NetworkWeights f = random_stack({2, 32, 32, 2}, activation, Head::zero_at_origin, random, 1.0);
    const double bound = float32_error(f, Box::cube(2, 1.25));
    double largest = 0.0;
    for (int i = 0; i < 20000; ++i) {
      const Points x = (Points(1, 2) << random.uniform(-1.25, 1.25), random.uniform(-1.25, 1.25)).finished();
      const Eigen::VectorXf single = x.row(0).transpose().cast<float>();
      const Eigen::VectorXf y = in_float32(f, single) - in_float32(f, Eigen::VectorXf::Zero(2));
      largest = std::max(largest, (y.cast<double>() - f.value(x).row(0).transpose()).norm());
    }
    EXPECT_LE(largest, bound) << to_string(activation);
    EXPECT_LE(bound, 3000.0 * largest) << to_string(activation);
    EXPECT_LT(bound, 1e-2) << to_string(activation);
  }
  EXPECT_THROW(
      float64_error(random_stack({2, 4, 4}, Activation::tanh, Head::squared_norm, random), Box::cube(2, 1.0)),
      Error);
}

}  // namespace
}  // namespace s2nnds
