// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/taylor_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "s2nnds/verification/band_bound.h"
#include "s2nnds/verification/network_function.h"
#include "tests/verification/exact_network.h"

namespace s2nnds {
namespace {

constexpr Activation curved[] = {Activation::tanh, Activation::elu, Activation::softplus, Activation::silu,
                                 Activation::sine};

double log_uniform(RandomStream& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

// A number in [-1, 1], every fourth time an end.
double in_unit(RandomStream& random) {
  const std::size_t kind = random.below(8);
  return kind == 0 ? -1.0 : (kind == 1 ? 1.0 : random.uniform(-1.0, 1.0));
}

void expect_expansions_to_hold(Activation activation, int tiles, RandomStream& random) {
  for (int k = 0; k < tiles; ++k) {
    double z0[tile_boxes], radius[tile_boxes];
    for (int t = 0; t < tile_boxes; ++t) {
      z0[t] = random.below(4) == 0 ? log_uniform(random, 1e-6, 30.0) * (random.below(2) == 0 ? 1.0 : -1.0)
                                   : random.uniform(-4.0, 4.0);
      radius[t] = random.below(16) == 0 ? 0.0 : log_uniform(random, 1e-9, 20.0);
    }
    ActivationExpansion e;
    taylor_kernels().expand(activation, z0, radius, e);
    for (int t = 0; t < tile_boxes; ++t) {
      const Exact d = Exact(radius[t]) * in_unit(random), z = z0[t] + d;
      const Exact value = exact_activation(activation, z), slope = exact_slope(activation, z);
      const Exact linear = abs(value - e.value[t] - e.first[t] * d);
      const Exact quadratic = abs(value - e.value[t] - e.first[t] * d - e.second[t] * d * d / 2);
      const Exact first = abs(slope - e.first[t] - e.second[t] * d - e.third[t] * d * d / 2);
      ASSERT_LE(linear, e.linear_error[t])
          << to_string(activation) << " at " << z0[t] << " radius " << radius[t];
      ASSERT_LE(quadratic, e.value_error[t])
          << to_string(activation) << " at " << z0[t] << " radius " << radius[t];
      ASSERT_LE(first, e.first_error[t])
          << to_string(activation) << " at " << z0[t] << " radius " << radius[t];
      ASSERT_LE(
          abs(value - e.value[t] - e.first[t] * d - e.second[t] * d * d / 2 - e.third[t] * d * d * d / 6),
          e.value_rest[t])
          << to_string(activation) << " at " << z0[t] << " radius " << radius[t];
      ASSERT_LE(
          abs(slope - e.first[t] - e.second[t] * d - e.third[t] * d * d / 2 - e.fourth[t] * d * d * d / 6),
          e.first_rest[t])
          << to_string(activation) << " at " << z0[t] << " radius " << radius[t];
    }
  }
}

TEST(ActivationExpansion, HoldsTheExactFunctionAndItsDerivative) {
  RandomStream random(1, "expansion");
  for (Activation activation : curved) expect_expansions_to_hold(activation, 1300, random);
  expect_expansions_to_hold(Activation::identity, 10, random);
}

TEST(ActivationExpansion, DISABLED_HoldsAtAMillionPoints) {
  RandomStream random(2, "expansion");
  for (Activation activation : curved) expect_expansions_to_hold(activation, 15000, random);
}

// Tightness: against the largest error at 400 points of the range.
TEST(ActivationExpansion, IsTight) {
  RandomStream random(3, "tight");
  for (Activation activation : curved) {
    for (int k = 0; k < 300; ++k) {
      double z0[tile_boxes], radius[tile_boxes];
      for (int t = 0; t < tile_boxes; ++t) {
        z0[t] = random.uniform(-3.0, 3.0);
        radius[t] = log_uniform(random, 1e-2, 0.5);
      }
      ActivationExpansion e;
      taylor_kernels().expand(activation, z0, radius, e);
      double widest_value = 0.0, widest_first = 0.0, mean_value = 0.0, widest_rest = 0.0;
      for (int t = 0; t < tile_boxes; ++t) {
        // A jump inside costs an order; the bound of the third derivative allows a factor.
        if (activation == Activation::elu && std::abs(z0[t]) <= radius[t]) continue;
        const double scale = std::pow(radius[t], 3);
        widest_value = std::max(widest_value, e.value_error[t] / scale);
        widest_first = std::max(widest_first, e.first_error[t] / scale);
        widest_rest = std::max(widest_rest, e.value_rest[t] / std::pow(radius[t], 4));
        EXPECT_LE(e.first_rest[t], std::min(e.first_error[t], 16.1 / 24.0 * std::pow(radius[t], 4) + 1e-12));
        mean_value += e.linear_error[t] / (radius[t] * radius[t]) / tile_boxes;
      }
      EXPECT_LT(widest_value, 2.01 / 6.0);  // |tanh'''| <= 2
      EXPECT_LT(widest_first, 4.1 / 6.0);   // |tanh''''| <= 4.09
      EXPECT_LT(widest_rest, 4.1 / 24.0 + 1e-4);
      EXPECT_LT(mean_value, 0.51);
    }
  }
}

TEST(ActivationExpansion, ShrinksWithTheCubeOfTheRadius) {
  for (Activation activation : curved) {
    double z0[tile_boxes], radius[tile_boxes];
    for (int t = 0; t < tile_boxes; ++t) {
      z0[t] = -0.9;
      radius[t] = 0.4 * std::pow(0.5, t);
    }
    ActivationExpansion e;
    taylor_kernels().expand(activation, z0, radius, e);
    for (int t = 3; t + 1 < tile_boxes; ++t) {
      EXPECT_LT(e.value_error[t + 1], e.value_error[t] / 7.0) << to_string(activation);
      EXPECT_LT(e.first_error[t + 1], e.first_error[t] / 7.0) << to_string(activation);
      EXPECT_LT(e.linear_error[t + 1], e.linear_error[t] / 3.6) << to_string(activation);
      EXPECT_LT(e.value_rest[t + 1], e.value_rest[t] / 14.0 + 1e-12) << to_string(activation);
      EXPECT_LT(e.first_rest[t + 1], e.first_rest[t] / 14.0 + 1e-12) << to_string(activation);
    }
  }
}

TEST(ActivationExpansion, NotANumberStaysNotANumber) {
  for (Activation activation : curved) {
    double z0[tile_boxes], radius[tile_boxes];
    for (int t = 0; t < tile_boxes; ++t) {
      z0[t] = t % 2 == 0 ? std::nan("") : 0.5;
      radius[t] = t % 2 == 0 ? 0.1 : std::nan("");
    }
    ActivationExpansion e;
    taylor_kernels().expand(activation, z0, radius, e);
    EXPECT_TRUE(std::isnan(e.value[0])) << to_string(activation);
    EXPECT_FALSE(e.value_error[1] < 1e300) << to_string(activation);
    EXPECT_FALSE(e.linear_error[1] < 1e300) << to_string(activation);
    EXPECT_FALSE(e.first_error[1] < 1e300) << to_string(activation);
    EXPECT_FALSE(e.value_rest[1] < 1e300) << to_string(activation);
    EXPECT_FALSE(e.first_rest[1] < 1e300) << to_string(activation);
  }
}

struct RandomBoxes {
  Points lower, upper;

  RandomBoxes(Eigen::Index n, double smallest, double largest, RandomStream& random)
      : lower(tile_boxes, n), upper(tile_boxes, n) {
    for (Eigen::Index t = 0; t < tile_boxes; ++t) {
      const double size = log_uniform(random, smallest, largest);
      for (Eigen::Index d = 0; d < n; ++d) {
        const double middle = random.uniform(-1.25, 1.25), half = size * random.uniform();
        lower(t, d) = middle - half;
        upper(t, d) = middle + half;
      }
    }
  }
};

ExactVector point_of(const RandomBoxes& boxes, Eigen::Index t, RandomStream& random) {
  ExactVector x;
  for (Eigen::Index d = 0; d < boxes.lower.cols(); ++d) {
    const Exact low = boxes.lower(t, d), high = boxes.upper(t, d);
    x.push_back((low + high) / 2 + (high - low) / 2 * in_unit(random));
  }
  return x;
}

void expect_form_to_hold(const TileForm& form, const BoxTile& tile, Eigen::Index t, const ExactVector& x,
                         const Exact& exact) {
  ASSERT_LE(exact, form.upper(tile)(t));
  ASSERT_GE(exact, form.lower(tile)(t));
  Exact polynomial = form.value(t);
  std::size_t at = 0;
  for (std::size_t d = 0; d < x.size(); ++d) {
    for (std::size_t e = 0; e < x.size(); ++e) {
      for (std::size_t g = e; g < x.size(); ++g) {
        polynomial += form.cubic[at++](t) * (x[d] - tile.center[d](t)) * (x[e] - tile.center[e](t)) *
                      (x[g] - tile.center[g](t));
      }
    }
  }
  at = 0;
  for (std::size_t d = 0; d < x.size(); ++d) {
    const Exact dx = x[d] - tile.center[d](t);
    polynomial += form.gradient[d](t) * dx + form.hessian[at++](t) * dx * dx / 2;
    for (std::size_t e = d + 1; e < x.size(); ++e)
      polynomial += form.hessian[at++](t) * dx * (x[e] - tile.center[e](t));
  }
  ASSERT_LE(abs(exact - polynomial), form.remainder(t) * (1 + 1e-11) + 1e-11 * form.magnitude(t) + 1e-15);
}

void expect_models_to_hold(const TileModels& models, Eigen::Index i, const BoxTile& tile, Eigen::Index t,
                           const ExactVector& x, const Exact& exact) {
  Exact polynomial = models.value(i)(t);
  Eigen::Index at = 0;
  for (std::size_t d = 0; d < x.size(); ++d) {
    const Exact dx = x[d] - tile.center[d](t);
    polynomial += models.slope(i)[d](t) * dx + models.hessian(i)[at++](t) * dx * dx / 2;
    for (std::size_t e = d + 1; e < x.size(); ++e)
      polynomial += models.hessian(i)[at++](t) * dx * (x[e] - tile.center[e](t));
  }
  ASSERT_LE(abs(exact - polynomial), models.remainder[static_cast<std::size_t>(i)](t));
}

// Random networks, heads and boxes: values, Lie derivatives, gradients and partial derivatives, `points` a box.
void expect_networks_to_hold(int networks, int points, RandomStream& random) {
  for (int k = 0; k < networks; ++k) {
    const Activation activation = curved[k % 5];
    const Eigen::Index n = 1 + static_cast<Eigen::Index>(random.below(4)), width = 3 + random.below(4);
    const NetworkWeights f =
        random_stack({n, width, n}, curved[random.below(5)], Head::zero_at_origin, random);
    const bool norm = random.below(2) == 0;
    const NetworkWeights y = norm ? random_stack({n, width, width, 3}, activation, Head::squared_norm, random)
                                  : random_stack({n, width, width, 1}, activation, Head::plain, random);
    const NetworkFunction field(f), function(y);
    ScalarEnclosure enclosure(function, &field);
    const RandomBoxes boxes(n, 1e-7, 0.5, random);
    BoxTile tile(n);
    tile.assign(boxes.lower, boxes.upper, 0, tile_boxes);
    const TileForm value = enclosure.value(tile), rate = enclosure.lie_derivative(tile);
    const TileForm partial = enclosure.partial_derivative(tile, n - 1);
    const TileModels gradient = enclosure.gradient(tile);
    for (Eigen::Index t = 0; t < tile_boxes; ++t) {
      for (int i = 0; i < points; ++i) {
        const ExactVector x = point_of(boxes, t, random), zero(n, 0);
        ExactVector axis = zero;
        axis.back() = 1;
        const ExactValue exact = exact_network(y, x, exact_network(f, x, zero).value);
        expect_form_to_hold(value, tile, t, x, exact.value[0]);
        expect_form_to_hold(rate, tile, t, x, exact.rate[0]);
        expect_form_to_hold(partial, tile, t, x, exact_network(y, x, axis).rate[0]);
        for (Eigen::Index d = 0; d < n; ++d) {
          axis = zero;
          axis[static_cast<std::size_t>(d)] = 1;
          expect_models_to_hold(gradient, d, tile, t, x, exact_network(y, x, axis).rate[0]);
        }
        const double band = std::nextafter(static_cast<double>(abs(exact.value[0])), INFINITY);
        ASSERT_LE(exact.rate[0], upper_within(rate, value, band, tile)(t))
            << "n = " << n << ", band " << band;
        TileForm below = value;  // <= 0 at x
        below.value -= std::nextafter(static_cast<double>(exact.value[0]), INFINITY);
        below.magnitude += std::abs(static_cast<double>(exact.value[0]));
        ASSERT_LE(exact.rate[0], upper_below(rate, below, tile)(t)) << "n = " << n;
        ASSERT_LE(-exact.rate[0], upper_below(rate.negative(), below, tile)(t)) << "n = " << n;
      }
    }
  }
}

TEST(TaylorModel, HoldsTheExactNetwork) {
  RandomStream random(4, "networks");
  expect_networks_to_hold(100, 3, random);
}

TEST(TaylorModel, DISABLED_HoldsTheExactNetworkAtAMillionPoints) {
  RandomStream random(5, "networks");
  expect_networks_to_hold(5000, 13, random);
}

TEST(TaylorModel, VectorFieldModelsHoldTheExactField) {
  RandomStream random(6, "models");
  for (int k = 0; k < 60; ++k) {
    const NetworkWeights f =
        random_stack({2, 5, 5, 2}, curved[k % 5], k % 2 == 0 ? Head::zero_at_origin : Head::plain, random);
    const NetworkFunction field(f);
    const RandomBoxes boxes(2, 1e-6, 0.5, random);
    BoxTile tile(2);
    tile.assign(boxes.lower, boxes.upper, 0, tile_boxes);
    const auto workspace = field.workspace();
    TileModels models(2, 2);
    field.models(tile, *workspace, models);
    for (Eigen::Index t = 0; t < tile_boxes; ++t) {
      const ExactVector x = point_of(boxes, t, random);
      const ExactVector exact = exact_network(f, x, {0, 0}).value;
      for (Eigen::Index i = 0; i < 2; ++i) {
        Exact line = models.value(i)(t), bend = 0;
        const TileRow* hessian = models.hessian(i);
        for (Eigen::Index d = 0; d < 2; ++d) {
          const Exact dx = x[d] - tile.center[d](t);
          line += models.slope(i)[d](t) * dx;
          bend += (*hessian++)(t)*dx * dx / 2;
          for (Eigen::Index e = d + 1; e < 2; ++e) bend += (*hessian++)(t)*dx * (x[e] - tile.center[e](t));
        }
        ASSERT_LE(abs(exact[i] - line), models.deviation(i, tile)(t));
        ASSERT_LE(abs(exact[i] - line - bend), models.remainder[i](t));
      }
    }
  }
}

// The excess over the exact range shrinks with the square of the box; the remainder with its fourth power.
TEST(TaylorModel, ExcessShrinksQuadratically) {
  RandomStream random(7, "tightness");
  for (Activation activation : {Activation::tanh, Activation::softplus, Activation::silu, Activation::sine}) {
    const NetworkWeights f = random_stack({2, 16, 16, 2}, activation, Head::zero_at_origin, random);
    const NetworkWeights v = random_stack({2, 16, 16, 8}, activation, Head::squared_norm, random);
    const NetworkFunction field(f), function(v);
    ScalarEnclosure enclosure(function, &field);
    double widest = 0.0, previous_remainder = 0.0, excess = 0.0;
    for (double half : {0.04, 0.02, 0.01, 0.005}) {
      Points lower(1, 2), upper(1, 2);
      lower << 0.3 - half, -0.4 - half;
      upper << 0.3 + half, -0.4 + half;
      BoxTile tile(2);
      tile.assign(lower, upper, 0, 1);
      const TileForm& form = enclosure.lie_derivative(tile);
      double low = INFINITY, high = -INFINITY;
      for (int i = 0; i <= 40; ++i) {
        for (int j = 0; j <= 40; ++j) {
          const Points x =
              (Points(1, 2) << 0.3 + half * (i / 20.0 - 1.0), -0.4 + half * (j / 20.0 - 1.0)).finished();
          Points value, rate;
          v.value_and_derivative(x, f.value(x), value, rate);
          low = std::min(low, rate(0, 0));
          high = std::max(high, rate(0, 0));
        }
      }
      excess = (form.upper(tile)(0) - high) + (low - form.lower(tile)(0));
      EXPECT_GE(excess, -1e-12);
      if (widest == 0.0) {
        widest = excess;
      } else {
        EXPECT_LT(form.remainder(0), previous_remainder / 14.0) << to_string(activation) << " half " << half;
      }
      previous_remainder = form.remainder(0);
    }
    EXPECT_LT(excess, widest / std::pow(3.5, 3)) << to_string(activation);
  }
}

// In a thin band around {y = 0} through the middle of a box, the rate's bound is near the largest rate there, of which
// the bound on all of the box is far.
TEST(TaylorModel, BoundsWithinABandAreTight) {
  RandomStream random(9, "band");
  const Eigen::Index n = 4;
  double within = 0.0, everywhere = 0.0;
  for (int k = 0; k < 20; ++k) {
    const NetworkWeights f = random_stack({n, 16, n}, Activation::tanh, Head::zero_at_origin, random);
    NetworkWeights y = random_stack({n, 16, 1}, Activation::tanh, Head::plain, random);
    const double half = 0.01, band = 1e-4;
    const Points middle = Points::NullaryExpr(1, n, [&] { return random.uniform(-1.0, 1.0); });
    y.layers.back().bias = Vector::Zero(1);
    y.layers.back().bias(0) = -y.value(middle)(0, 0);
    const NetworkFunction field(f), function(y);
    ScalarEnclosure enclosure(function, &field);
    BoxTile tile(n);
    tile.assign(middle.array() - half, middle.array() + half, 0, 1);
    const TileForm value = enclosure.value(tile), rate = enclosure.lie_derivative(tile);
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < 20000; ++i) {
      Points x = middle;
      for (Eigen::Index d = 0; d < n; ++d) x(0, d) += half * in_unit(random);
      // Into the band, along y's steepest axis.
      Eigen::Index steepest = 0;
      double slope = 0.0;
      for (Eigen::Index d = 0; d < n; ++d) {
        if (std::abs(value.gradient[d](0)) > std::abs(slope)) slope = value.gradient[steepest = d](0);
      }
      x(0, steepest) -= y.value(x)(0, 0) / slope;
      Points values, rates;
      y.value_and_derivative(x, f.value(x), values, rates);
      if (std::abs(values(0, 0)) > band || std::abs(x(0, steepest) - middle(0, steepest)) > half) continue;
      low = std::min(low, rates(0, 0));
      high = std::max(high, rates(0, 0));
    }
    ASSERT_LT(low, high);
    EXPECT_GE(upper_within(rate, value, band, tile)(0), high);
    within += (upper_within(rate, value, band, tile)(0) - high) / (high - low);
    everywhere += (rate.upper(tile)(0) - high) / (high - low);
  }
  EXPECT_LT(within / 20, 0.1);
  EXPECT_GT(everywhere / 20, 0.2);
}

// x - y wherever x <= 0, on |x|, |y| <= 0.1: 0.1, of which the bound on all of the box is 0.2; wherever x >= 0 nothing is won.
TEST(TaylorModel, BoundsBelowALevelAreKnown) {
  BoxTile tile(2);
  for (TileRow& row : tile.half) row.setConstant(0.1);
  TileForm q(2), level(2);
  q.gradient[0].setOnes();
  q.gradient[1].setConstant(-1.0);
  level.gradient[0].setOnes();
  EXPECT_NEAR(upper_below(q, level, tile)(0), 0.1, 1e-12);
  EXPECT_NEAR(upper_below(q, level.negative(), tile)(0), 0.2, 1e-12);
  level.gradient[0](0) = std::nan("");
  EXPECT_FALSE(upper_below(q, level, tile)(0) < 0.2);
}

// A form that is not a number, or a band around one, gives no bound.
TEST(TaylorModel, NotANumberBoundsNothingWithinABand) {
  BoxTile tile(2);
  for (TileRow& row : tile.half) row.setConstant(0.1);
  TileForm rate(2), level(2);
  rate.value.setConstant(-1.0);
  rate.gradient[0].setOnes();
  level.gradient[0].setOnes();
  EXPECT_LT(upper_within(rate, level, 0.01, tile)(0), 0.0);
  TileForm broken = rate;
  broken.gradient[1](0) = std::nan("");
  EXPECT_FALSE(upper_within(broken, level, 0.01, tile)(0) < 1e300);
  broken = level;
  broken.value(0) = std::nan("");
  EXPECT_FALSE(upper_within(rate, broken, 0.01, tile)(0) < 1e300);
}

// A point costs only rounding errors.
TEST(TaylorModel, PointsAreEvaluatedToRounding) {
  RandomStream random(8, "points");
  const NetworkWeights f = random_stack({2, 64, 64, 64, 2}, Activation::tanh, Head::zero_at_origin, random);
  const NetworkWeights v = random_stack({2, 64, 64, 32}, Activation::tanh, Head::squared_norm, random);
  const NetworkFunction field(f), function(v);
  ScalarEnclosure enclosure(function, &field);
  const Points point = (Points(1, 2) << 0.7, -0.2).finished();
  BoxTile tile(2);
  tile.assign(point, point, 0, 1);
  const TileForm& form = enclosure.lie_derivative(tile);
  const double width = form.upper(tile)(0) - form.lower(tile)(0);
  EXPECT_GT(width, 0.0);
  EXPECT_LT(width, 1e-8 * std::abs(form.value(0)));
}

// On small boxes a gradient's models leave hardly more open than the form of each partial derivative.
TEST(TaylorModel, GradientsAreTightOnSmallBoxes) {
  RandomStream random(9, "gradient");
  for (const Head head : {Head::plain, Head::squared_norm}) {
    for (int k = 0; k < 20; ++k) {
      const NetworkFunction function(
          random_stack({2, 6, 6, head == Head::plain ? 1 : 3}, Activation::tanh, head, random));
      ScalarEnclosure enclosure(function, nullptr);
      const RandomBoxes boxes(2, 1e-4, 1e-3, random);
      BoxTile tile(2);
      tile.assign(boxes.lower, boxes.upper, 0, tile_boxes);
      const TileModels gradient = enclosure.gradient(tile);
      for (Eigen::Index d = 0; d < 2; ++d) {
        const TileForm& partial = enclosure.partial_derivative(tile, d);
        const TileRow width = 2.0 * (gradient.spread(d, tile) + gradient.deviation(d, tile));
        EXPECT_TRUE((width <= 1.01 * (partial.upper(tile) - partial.lower(tile)) + 1e-5).all());
      }
    }
  }
}

// One sweep for all axes gives what one for each gives.
TEST(NetworkFunction, HasTheModelsOfItsJacobianInOneSweep) {
  RandomStream random(5, "jacobian");
  NetworkWeights stack;
  for (const auto& [rows, columns] : {std::pair{7, 3}, {5, 7}, {2, 5}}) {
    Layer layer;
    layer.weight = Points::NullaryExpr(rows, columns, [&] { return random.uniform(-1.0, 1.0); });
    layer.bias = Vector::NullaryExpr(rows, [&] { return random.uniform(-1.0, 1.0); });
    layer.activation = rows == 2 ? Activation::identity : Activation::tanh;
    stack.layers.push_back(layer);
  }
  stack.head = Head::zero_at_origin;
  const NetworkFunction f(stack);
  const auto memory = f.workspace();
  Points lower = Points::NullaryExpr(tile_boxes, 3, [&] { return random.uniform(-1.0, 1.0); });
  const Points upper = lower.array() + 0.1;
  BoxTile tile(3);
  tile.assign(lower, upper, 0, tile_boxes);
  TileModels y(2, 3), expected(2, 3);
  std::vector<TileModels> partials(3, y);
  f.jacobian_models(tile, *memory, y, partials);
  const auto expect_same = [&](const TileModels& found) {
    for (std::size_t i = 0; i < expected.models.size(); ++i) {
      EXPECT_LE((found.models[i] - expected.models[i]).abs().maxCoeff(), 1e-14);
    }
    for (std::size_t i = 0; i < expected.remainder.size(); ++i) {
      EXPECT_LE((found.remainder[i] - expected.remainder[i]).abs().maxCoeff(), 1e-14);
    }
  };
  f.models(tile, *memory, expected);
  expect_same(y);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    f.partial_models(tile, *memory, axis, expected);
    expect_same(partials[static_cast<std::size_t>(axis)]);
  }
}

}  // namespace
}  // namespace s2nnds
