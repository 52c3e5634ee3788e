// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/fused_network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/networks/evaluator.h"

namespace s2nnds {
namespace {

double scalar(Activation activation, double z) {
  switch (activation) {
    case Activation::identity:
      return z;
    case Activation::tanh:
      return std::tanh(z);
    case Activation::elu:
      return z > 0 ? z : std::expm1(z);
    case Activation::softplus:
      return z > 30 ? z : std::log1p(std::exp(z));
    case Activation::silu:
      return z / (1 + std::exp(-z));
    case Activation::sine:
      return std::sin(z);
  }
  return NAN;
}

NetworkWeights random_stack(std::vector<int> sizes, Activation activation, bool bias, RandomStream& random) {
  NetworkWeights stack;
  for (std::size_t l = 0; l + 1 < sizes.size(); ++l) {
    Layer layer;
    layer.weight =
        Points::NullaryExpr(sizes[l + 1], sizes[l], [&] { return random.normal() / std::sqrt(sizes[l]); });
    if (bias) layer.bias = Vector::NullaryExpr(sizes[l + 1], [&] { return random.normal(); });
    layer.activation = l + 2 < sizes.size() ? activation : Activation::identity;
    stack.layers.push_back(layer);
  }
  return stack;
}

Vector reference(const NetworkWeights& stack, Vector a) {
  for (const Layer& layer : stack.layers) {
    Vector z = layer.weight * a;
    if (layer.bias.size()) z += layer.bias;
    a = z.unaryExpr([&](double v) { return scalar(layer.activation, v); });
  }
  return a;
}

class EveryActivation : public testing::TestWithParam<Activation> {};

TEST_P(EveryActivation, KernelsMatchTheLibraryFunctions) {
  std::vector<double> z, value(4000), first(4000), second(4000);
  for (int i = 0; i < 4000; ++i) z.push_back(-40.0 + 0.02 * i + 1e-3 * std::sin(i));
  dense_kernels<double>().activate(GetParam(), 4000, z.data(), value.data(), first.data(), second.data());
  const double h = 1e-5;
  for (int i = 0; i < 4000; ++i) {
    const double exact = scalar(GetParam(), z[i]);
    ASSERT_NEAR(value[i], exact, 4e-15 * std::max(1.0, std::abs(exact))) << "at " << z[i];
    if (GetParam() == Activation::elu && std::abs(z[i]) < 1e-3) continue;  // sigma'' jumps there
    ASSERT_NEAR(first[i], (scalar(GetParam(), z[i] + h) - scalar(GetParam(), z[i] - h)) / (2 * h), 1e-8);
    ASSERT_NEAR(second[i],
                (scalar(GetParam(), z[i] + h) - 2 * exact + scalar(GetParam(), z[i] - h)) / (h * h), 2e-4);
  }
}

TEST_P(EveryActivation, NotANumberStaysNotANumber) {
  std::vector<double> z(16, NAN), value(16), first(16), second(16);
  dense_kernels<double>().activate(GetParam(), 16, z.data(), value.data(), first.data(), second.data());
  EXPECT_TRUE(std::isnan(value[0]) && std::isnan(value[15]));
}

TEST_P(EveryActivation, EvaluatorMatchesPlainLoopsOverShapesAndHeads) {
  RandomStream random(7, "evaluator test", static_cast<std::uint64_t>(GetParam()));
  for (const auto& sizes : {std::vector<int>{2, 64, 64, 2}, {3, 32, 17, 5, 3}, {6, 100, 1}, {2, 2}}) {
    for (Head head : {Head::plain, Head::zero_at_origin, Head::squared_norm}) {
      NetworkWeights stack = random_stack(sizes, GetParam(), true, random);
      stack.head = head;
      stack.quadratic = head == Head::squared_norm ? 0.05 : 0.0;
      const Points x = Points::NullaryExpr(131, sizes[0], [&] { return random.uniform(-2, 2); });
      const Points d = Points::NullaryExpr(131, sizes[0], [&] { return random.normal(); });
      const auto exact = [&](const Vector& at) -> Vector {
        const Vector zero = Vector::Zero(at.size());
        if (head == Head::plain) return reference(stack, at);
        const Vector u = reference(stack, at) - reference(stack, zero);
        if (head == Head::zero_at_origin) return u;
        return Vector::Constant(1, u.squaredNorm() + stack.quadratic * at.squaredNorm());
      };
      Points value, derivative;
      stack.value_and_derivative(x, d, value, derivative);
      EXPECT_EQ(value, stack.value(x));
      for (int i = 0; i < x.rows(); ++i) {
        const Vector at = x.row(i), along = d.row(i);
        ASSERT_LT((exact(at) - value.row(i).transpose()).norm(), 1e-12 * (1 + exact(at).norm()));
        const double h = 1e-5;
        const Vector slope = (exact(at + h * along) - exact(at - h * along)) / (2 * h);
        ASSERT_LT((slope - derivative.row(i).transpose()).norm(), 1e-6 * (1 + slope.norm()));
      }
      const Points zero = Points::Zero(1, sizes[0]);
      if (head != Head::plain) {
        EXPECT_EQ(stack.value(zero).norm(), 0.0);
      }
    }
  }
}

// The reverse sweep over two tiles against central differences of <adjoint, value> + <adjoint', derivative>.
TEST_P(EveryActivation, ReverseSweepMatchesDifferences) {
  for (bool bias : {true, false}) {
    FusedNetwork<double> network(
        {{3, 20, bias, GetParam()}, {20, 33, bias, GetParam()}, {33, 2, bias, Activation::identity}});
    RandomStream random(11, "reverse sweep");
    const auto draw = [&](std::ptrdiff_t count) {
      std::vector<double> v(count);
      for (double& e : v) e = random.normal();
      return v;
    };
    constexpr std::ptrdiff_t tile = FusedNetwork<double>::tile_rows, samples = tile + 31;
    std::vector<double> theta = draw(network.parameters()), x = draw(samples * 3), d = draw(samples * 3);
    for (double& t : theta) t *= 0.3;
    const std::vector<double> a = draw(samples * 2), t = draw(samples * 2);
    std::vector<double> value(samples * 2), derivative(samples * 2);
    const auto objective = [&] {
      network.load(theta.data());
      network.forward(samples, x.data(), d.data(), value.data(), derivative.data());
      double sum = 0;
      for (std::size_t i = 0; i < value.size(); ++i) sum += a[i] * value[i] + t[i] * derivative[i];
      return sum;
    };
    objective();
    const std::vector<double> whole = value;
    FusedTile<double> sweep(network);
    std::vector<double> gradient(theta.size()), adjoint_direction(samples * 3);
    for (std::ptrdiff_t first = 0; first < samples; first += tile) {
      const std::ptrdiff_t rows = std::min(tile, samples - first);
      sweep.forward(rows, x.data() + 3 * first, d.data() + 3 * first, value.data() + 2 * first,
                    derivative.data() + 2 * first);
      sweep.backward(a.data() + 2 * first, t.data() + 2 * first, adjoint_direction.data() + 3 * first);
    }
    sweep.unpack_gradient(gradient.data());
    EXPECT_EQ(value, whole);
    const double h = 1e-6;
    const auto slope = [&](double& of) {
      const double kept = of;
      of = kept + h;
      const double up = objective();
      of = kept - h;
      const double down = objective();
      of = kept;
      return (up - down) / (2 * h);
    };
    for (std::size_t i = 0; i < theta.size(); i += 7) {
      const double expected = slope(theta[i]);
      ASSERT_NEAR(gradient[i], expected, 2e-5 * (1 + std::abs(expected)));
    }
    for (std::size_t i = 0; i < d.size(); i += 13) {
      const double expected = slope(d[i]);
      ASSERT_NEAR(adjoint_direction[i], expected, 2e-5 * (1 + std::abs(expected)));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryActivation,
                         testing::Values(Activation::identity, Activation::tanh, Activation::elu,
                                         Activation::softplus, Activation::silu, Activation::sine),
                         [](const auto& test) { return std::string(to_string(test.param)); });

TEST(NetworkWeights, RefusesShapesThatDoNotFit) {
  RandomStream random(1, "shapes");
  NetworkWeights stack = random_stack({2, 8, 1}, Activation::tanh, true, random);
  EXPECT_NO_THROW(stack.check());
  stack.layers[1].weight.resize(1, 7);
  EXPECT_THROW(stack.check(), Error);
  EXPECT_THROW(random_stack({2, 8, 1}, Activation::tanh, true, random).value(Points::Zero(4, 3)), Error);
}

TEST(WeightHash, SeesEveryChange) {
  RandomStream random(1, "hash");
  Networks networks;
  networks.f = networks.V = networks.B = random_stack({2, 8, 1}, Activation::tanh, true, random);
  const std::string before = weight_hash(networks);
  EXPECT_EQ(before.size(), 64U);
  Networks other = networks;
  other.B.layers[0].weight(3, 1) = std::nextafter(other.B.layers[0].weight(3, 1), 10.0);
  EXPECT_NE(before, weight_hash(other));
  other = networks;
  other.V.head = Head::zero_at_origin;
  EXPECT_NE(before, weight_hash(other));
  EXPECT_EQ(before, weight_hash(networks));
}

}  // namespace
}  // namespace s2nnds
