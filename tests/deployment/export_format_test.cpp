// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/export_format.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "random_policy.h"
#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

namespace fs = std::filesystem;

Networks small_networks(RandomStream& random) {
  return {random_stack({2, 5, 2}, Activation::tanh, true, true, random),
          random_stack({2, 4, 1}, Activation::tanh, true, true, random),
          random_stack({2, 4, 1}, Activation::tanh, true, true, random)};
}

class EveryFormat : public testing::Test {
 protected:
  EveryFormat() : folder_(fs::temp_directory_path() / ("s2nnds-formats-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~EveryFormat() override { fs::remove_all(folder_); }

  // No format writes the policy, and each says why; `but` is one that can write it.
  void expect_refused(const Policy& policy, const std::string& words, std::string_view but = "") const {
    for (const ExportFormat& format : export_formats()) {
      if (format.name == but) continue;
      try {
        export_policy(policy, format, {}, (folder_ / "policy").string());
        ADD_FAILURE() << format.name << ": expected an Error about " << words;
      } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << format.name << ": " << e.what();
      }
    }
    EXPECT_TRUE(fs::is_empty(folder_));
  }

  fs::path folder_;
  RandomStream random_{12, "formats"};
  Policy policy_ = random_policy(small_networks(random_));
};

TEST_F(EveryFormat, HasANameAndAnEndingOfItsOwn) {
  std::set<std::string_view> names, endings;
  for (const ExportFormat& format : export_formats()) {
    names.insert(format.name);
    endings.insert(format.ending);
    EXPECT_EQ(&export_format_from(format.name), &format);
  }
  EXPECT_EQ(names.size(), export_formats().size());
  EXPECT_EQ(endings.size(), export_formats().size());
  EXPECT_THROW(export_format_from("word"), Error);
}

// Names and values stand in every file as text, but for the numbers of TorchScript. Those of pt2, which needs a
// Python with a new torch, are checked by tests/program/formats_test.py.
TEST_F(EveryFormat, CarriesEveryField) {
  for (const ExportFormat& format : export_formats()) {
    if (format.name == "pt2") continue;
    const std::string bytes = format.contents(policy_, {}, "policy");
    policy_.info.visit([&](const std::string& name, const auto& value, const char*) {
      EXPECT_NE(bytes.find(name), std::string::npos) << format.name << " " << name;
      if constexpr (std::is_same_v<decltype(value), const std::string&>) {
        if (value.find_first_of("\"\n") != std::string::npos) return;
        EXPECT_NE(bytes.find(value), std::string::npos) << format.name << " " << name;
      }
    });
  }
}

TEST_F(EveryFormat, RefusesAProjectionThatItDoesNotSayOrCannotMake) {
  policy_.networks.decay = 0.5;
  policy_.info.weight_hash = weight_hash(policy_.networks);
  expect_refused(policy_, "decay");  // V is no diffeomorphism, and nothing is said of it
  policy_.info.decay = 1.0;
  expect_refused(policy_, "diffeomorphism");
}

TEST_F(EveryFormat, RefusesWeightsOtherThanThoseCertified) {
  policy_.networks.f.layers[0].weight(0, 0) += 1e-9;
  expect_refused(policy_, "the certificate speaks of");
}

TEST_F(EveryFormat, RefusesShapesThatDoNotFit) {
  Policy wrong = policy_;
  wrong.info.workspace = {-1.0, 1.0};
  expect_refused(wrong, "workspace of 2 numbers, expected 4");
  wrong = policy_;
  wrong.info.goal = {1.0};
  expect_refused(wrong, "a goal of 1 numbers, expected 2");
  wrong = policy_;
  wrong.info.goal[1] = NAN;
  expect_refused(wrong, "not finite");
  wrong = policy_;
  wrong.info.dimension = 3;
  expect_refused(wrong, "expected 3 -> 3");
  wrong = policy_;
  wrong.info.position_scale = NAN;
  expect_refused(wrong, "scales");
  wrong = policy_;
  wrong.networks.f.layers[1].weight(0, 0) = NAN;
  expect_refused(wrong, "not a finite number");
}

TEST_F(EveryFormat, RefusesWeightsBeyondFloat) {
  Networks networks = policy_.networks;
  networks.f.layers[1].weight(0, 0) = 1e300;
  expect_refused(random_policy(networks), "--precision double", "pt2");
}

}  // namespace
}  // namespace s2nnds
