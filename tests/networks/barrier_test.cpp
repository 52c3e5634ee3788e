// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/barrier.h"

#include <gtest/gtest.h>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

Barrier a_barrier(std::int64_t dimension, const BarrierOptions& options) {
  RandomStream random(3, "barrier");
  return Barrier(dimension, options, random);
}

TEST(Barrier, BeginsAlongTheSidesOfABox) {
  const Box box = {Vector{{-1.0, -0.5}}, Vector{{2.0, 0.25}}};
  Barrier B = a_barrier(2, {});
  const std::vector<Layer> before = B->snapshot().layers;
  B->lay_along(box, 7.0);
  const std::vector<Layer> after = B->snapshot().layers;
  const auto taken_in = [&](Eigen::Index neuron, double x, double y) {
    return after[0].weight.row(neuron).dot(Vector{{x, y}}) + after[0].bias[neuron];
  };
  // Outwards of each side, and along it nothing changes.
  EXPECT_FLOAT_EQ(taken_in(0, 2.1, 0.2), 0.7);
  EXPECT_FLOAT_EQ(taken_in(1, -1.1, -0.4), 0.7);
  EXPECT_FLOAT_EQ(taken_in(2, 0.3, 0.35), 0.7);
  EXPECT_FLOAT_EQ(taken_in(3, -0.9, -0.6), 0.7);
  const Eigen::Index others = after[0].weight.rows() - 4;
  EXPECT_EQ(after[0].weight.bottomRows(others), before[0].weight.bottomRows(others));
  for (std::size_t layer = 1; layer < before.size(); ++layer)
    EXPECT_EQ(after[layer].weight, before[layer].weight);
}

TEST(Barrier, NeedsANeuronForEverySide) {
  const Box box = Box::cube(3, 1.0);
  EXPECT_THROW(a_barrier(3, {.network = {.hidden = {5}}})->lay_along(box, 1.0), Error);
  EXPECT_THROW(a_barrier(3, {.network = {.hidden = {8}, .bias = false}})->lay_along(box, 1.0), Error);
  EXPECT_THROW(a_barrier(2, {})->lay_along(box, 1.0), Error);
}

}  // namespace
}  // namespace s2nnds
