// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/lipschitz_limit.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>

#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

using Weight = Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

double product_of_norms(const std::vector<LayerShape>& layers, std::vector<float>& parameters) {
  double product = 1.0;
  float* at = parameters.data();
  for (const LayerShape& layer : layers) {
    const Eigen::MatrixXd weight = Weight(at, layer.outputs, layer.inputs).cast<double>();
    product *= Eigen::JacobiSVD<Eigen::MatrixXd>(weight).singularValues()[0];
    at += layer.parameters();
  }
  return product;
}

TEST(LipschitzLimit, KeepsTheProductAtTheLimitAsTheWeightsMove) {
  const std::vector<LayerShape> layers = {{6, 64}, {64, 64}, {64, 6, false}};
  RandomStream random(1, "limit");
  std::vector<float> parameters(6 * 64 + 64 + 64 * 64 + 64 + 64 * 6);
  for (float& parameter : parameters) parameter = static_cast<float>(random.normal() / 5.0);
  ASSERT_GT(product_of_norms(layers, parameters), 2.0);
  LipschitzLimit limit(layers, 0.9);
  limit.keep(parameters.data(), 30);
  EXPECT_NEAR(product_of_norms(layers, parameters), 0.9, 5e-3);
  for (int step = 0; step < 200; ++step) {
    for (float& parameter : parameters) parameter += static_cast<float>(2e-3 * random.normal());
    limit.keep(parameters.data(), 1);
    EXPECT_LT(product_of_norms(layers, parameters), 0.97);
  }
  limit.keep(parameters.data(), 30);
  EXPECT_LT(product_of_norms(layers, parameters), 0.905);
  EXPECT_GT(product_of_norms(layers, parameters), 0.85);  // a step may have ended below the limit
}

TEST(LipschitzLimit, LeavesWhatIsBelowItAlone) {
  const std::vector<LayerShape> layers = {{2, 2}};
  std::vector<float> parameters = {0.5F, 0.0F, 0.0F, 0.2F, 3.0F, 4.0F}, before = parameters;
  LipschitzLimit limit(layers, 0.6);
  limit.keep(parameters.data(), 30);
  EXPECT_EQ(parameters, before);
  parameters[0] = 1.2F;
  limit.keep(parameters.data(), 30);
  EXPECT_NEAR(parameters[0], 0.6F, 1e-4);
  EXPECT_NEAR(parameters[3], 0.1F, 1e-4);
  EXPECT_EQ(parameters[4], 3.0F);  // biases do not count
  std::vector<float> zero(6, 0.0F);
  limit.keep(zero.data(), 3);
  EXPECT_EQ(zero, std::vector<float>(6, 0.0F));
}

}  // namespace
}  // namespace s2nnds
