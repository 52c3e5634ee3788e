// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/config.h"

#include <gtest/gtest.h>

#include <numeric>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

TEST(Config, EveryProfileComesBackFromItsText) {
  for (const char* profile : {"robust", "smooth", "paper", "imitation"}) {
    const Config config = default_config(profile);
    const std::string text = to_toml(config);
    EXPECT_EQ(to_toml(parse_config(text, "test")), text);
    EXPECT_EQ(to_toml(parse_config(std::string("profile = \"") + profile + "\"", "test")), text);
    EXPECT_NO_THROW(validate(config)) << profile;
  }
  EXPECT_THROW(default_config("other"), Error);
}

TEST(Config, ImitationAsksForNothingButTheDemonstrations) {
  const Config config = parse_config("profile = \"imitation\"", "test");
  const LossOptions& loss = config.training.loss;
  EXPECT_GT(loss.weight[LossTerm::imitation], 0.0);
  EXPECT_EQ(std::accumulate(loss.weight.begin(), loss.weight.end(), 0.0) - loss.weight[LossTerm::imitation],
            0.0);
  EXPECT_EQ(config.training.rounds, 5);
  EXPECT_NE(config.verification.method, Method::proof);
}

}  // namespace
}  // namespace s2nnds
