// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/torchscript.h"

#include <gtest/gtest.h>
#include <torch/script.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "boundary_positions.h"
#include "random_policy.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"

namespace s2nnds {
namespace {

namespace fs = std::filesystem;

Networks random_networks(int n, Activation activation, RandomStream& random) {
  Networks networks;
  networks.f = random_stack({n, 12, 9, n}, activation, true, true, random);
  networks.f.head = Head::zero_at_origin;
  networks.V = random_stack({n, 10, 7}, activation, true, true, random);
  networks.V.head = Head::squared_norm;
  networks.V.quadratic = 0.3;
  networks.B = random_stack({n, 8, 8, 1}, activation, false, true, random);
  return networks;
}

Points to_points(const torch::Tensor& values) {
  const torch::Tensor t = values.to(torch::kFloat64).reshape({values.size(0), -1}).contiguous();
  return Eigen::Map<const Points>(t.data_ptr<double>(), t.size(0), t.size(1));
}

double error(const torch::Tensor& found, const Points& expected) {
  return (to_points(found) - expected).cwiseAbs().maxCoeff() / std::max(1.0, expected.cwiseAbs().maxCoeff());
}

class Torchscript : public testing::Test {
 protected:
  Torchscript() : folder_(fs::temp_directory_path() / ("s2nnds-torchscript-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~Torchscript() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
  RandomStream random_{7, "torchscript"};
};

TEST_F(Torchscript, EvaluatesTheSameNetworksInTheDatasUnit) {
  for (const Activation activation :
       {Activation::tanh, Activation::elu, Activation::softplus, Activation::silu, Activation::sine}) {
    for (const int n : {2, 3}) {
      const Networks networks = random_networks(n, activation, random_);
      write_policy(networks, "torchscript", path("policy.pt"));
      torch::jit::Module policy = torch::jit::load(path("policy.pt"));
      const Points z = Points::NullaryExpr(200, n, [&] { return random_.normal(); });
      Points raw = positions(z);
      const auto compare = [&](torch::ScalarType type, double tolerance) {
        const torch::Tensor x = torch::from_blob(raw.data(), {200, n}, torch::kFloat64).to(type);
        const torch::Tensor velocity = policy.forward({x}).toTensor();
        EXPECT_EQ(velocity.scalar_type(), type);
        EXPECT_LT(error(velocity, 25.0 * networks.f.value(z)), tolerance) << to_string(activation);
        EXPECT_LT(error(policy.run_method("lyapunov", x).toTensor(), networks.V.value(z)), tolerance);
        EXPECT_LT(error(policy.run_method("barrier", x).toTensor(), networks.B.value(z)), tolerance);
      };
      compare(torch::kFloat32, 1e-5);
      policy.to(torch::kFloat64);
      compare(torch::kFloat64, 1e-6);  // N(0), which the heads subtract, is stored in float32
    }
  }
}

TEST_F(Torchscript, CarriesWhatIsGuaranteedOfWhichWeights) {
  const Networks networks = random_networks(2, Activation::tanh, random_);
  write_policy(networks, "torchscript", path("policy.pt"));
  const torch::jit::Module policy = torch::jit::load(path("policy.pt"));
  EXPECT_EQ(policy.attr("guarantee").toStringRef(), "conformal");
  EXPECT_EQ(policy.attr("statement").toStringRef(), random_policy(networks).info.statement);
  EXPECT_EQ(policy.attr("weight_hash").toStringRef(), weight_hash(networks));
  EXPECT_EQ(policy.attr("name").toStringRef(), random_policy(networks).info.name);
  EXPECT_EQ(policy.attr("unit").toStringRef(), "mm");
  EXPECT_EQ(policy.attr("dimension").toInt(), 2);
  EXPECT_EQ(policy.attr("position_scale").toDouble(), 40.0);
  EXPECT_EQ(policy.attr("velocity_scale").toDouble(), 25.0);
  EXPECT_EQ(policy.attr("disturbance_margin").toDouble(), 6.25);
  EXPECT_EQ(policy.attr("frame_name").toStringRef(), "base_link");
  EXPECT_EQ(policy.attr("goal").toDoubleVector(), (std::vector<double>{512.0, -256.0}));
  const std::vector<double> corners = {462.0, -306.0, 572.0, -196.0};
  EXPECT_EQ(policy.attr("workspace").toDoubleVector(), corners);
}

// A cast of the module must not round the goal.
TEST_F(Torchscript, FarFromTheOriginOnlyThePositionsPrecisionCounts) {
  Networks networks = random_networks(2, Activation::tanh, random_);
  Policy policy = random_policy(networks);
  policy.info.goal = {4.0e6 + 0.123456789, -7.0e5 - 0.987654321};
  policy.info.workspace = {3.9e6, -7.1e5, 4.1e6, -6.9e5};
  export_policy(policy, export_format_from("torchscript"), {}, path("far.pt"));
  torch::jit::Module module = torch::jit::load(path("far.pt"));
  const Points z = Points::NullaryExpr(50, 2, [&] { return random_.uniform(-1.0, 1.0); });
  Points raw = (40.0 * z).rowwise() + Eigen::RowVector2d(policy.info.goal[0], policy.info.goal[1]);
  const torch::Tensor x = torch::from_blob(raw.data(), {50, 2}, torch::kFloat64);
  for (const torch::ScalarType type : {torch::kFloat32, torch::kFloat64, torch::kFloat32}) {
    module.to(type);
    EXPECT_LT(error(module.forward({x}).toTensor(), 25.0 * networks.f.value(z)), 1e-6);
  }
}

TEST_F(Torchscript, SafeIsTheSublevelSetOfTheBarrierWithinTheWorkspace) {
  Networks networks = random_networks(2, Activation::tanh, random_);
  Layer above;  // B(x, y) = y
  above.weight = Points{{0.0, 1.0}};
  networks.B = {};
  networks.B.layers = {above};
  write_policy(networks, "torchscript", path("policy.pt"));
  torch::jit::Module policy = torch::jit::load(path("policy.pt"));
  // Workspace [-50, 60]^2 around the goal: below the line, above it, and below it but outside of the workspace.
  const torch::Tensor x =
      torch::tensor({{10.0, -5.0}, {10.0, 5.0}, {10.0, -55.0}, {-55.0, -5.0}, {59.0, -5.0}}) +
      torch::tensor({512.0, -256.0});
  const torch::Tensor safe = policy.run_method("safe", x).toTensor();
  EXPECT_TRUE(torch::equal(safe, torch::tensor({true, false, false, false, true}))) << safe;
}

// On {B = 0}, where rounding decides.
TEST_F(Torchscript, SafeIsNeverTrueWhereTheExactBarrierIsPositive) {
  for (const Activation activation : {Activation::tanh, Activation::silu}) {
    const Networks networks = with_barrier(random_networks(2, activation, random_), activation, random_);
    const Policy policy = random_policy(networks);
    write_policy(networks, "torchscript", path("policy.pt"));
    torch::jit::Module module = torch::jit::load(path("policy.pt"));
    Points raw = boundary_positions(policy, 300, random_);
    const torch::Tensor x = torch::from_blob(raw.data(), {raw.rows(), 2}, torch::kFloat64);
    double largest = 0.0;
    for (const torch::ScalarType type : {torch::kFloat32, torch::kFloat64}) {
      module.to(type);
      const Points barrier = to_points(module.run_method("barrier", x).toTensor());
      const Points safe = to_points(module.run_method("safe", x).toTensor());
      for (Eigen::Index i = 0; i < raw.rows(); ++i) {
        const Exact exact = exact_barrier(policy, raw.row(i));
        EXPECT_FALSE(safe(i) == 1.0 && exact > 0) << toString(type) << ' ' << i;
        largest = std::max(largest, std::abs(static_cast<double>(barrier(i) - exact)));
      }
    }
    EXPECT_LE(largest, policy.info.barrier_float32_error);
    EXPECT_LE(policy.info.barrier_float32_error, 1e4 * largest);
    module.to(torch::kFloat16);  // no bound covers it
    EXPECT_ANY_THROW(module.run_method("safe", x));
  }
}

TEST_F(Torchscript, WritesTheFileWholeOrNotAtAll) {
  const Networks networks = random_networks(2, Activation::tanh, random_);
  try {
    write_policy(networks, "torchscript", path("nowhere/policy.pt"));
    FAIL() << "expected an Error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("nowhere/policy.pt: cannot write"), std::string::npos) << e.what();
  }
  fs::create_directory(path("folder.pt"));
  EXPECT_THROW(write_policy(networks, "torchscript", path("folder.pt")), Error);
  EXPECT_EQ(files(), 1u);
  std::ofstream(path("policy.pt")) << "older";
  write_policy(networks, "torchscript", path("policy.pt"));
  EXPECT_EQ(torch::jit::load(path("policy.pt")).attr("name").toStringRef(),
            random_policy(networks).info.name);
  EXPECT_EQ(files(), 2u);
}

}  // namespace
}  // namespace s2nnds
