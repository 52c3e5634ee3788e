// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/cpp_header.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "boundary_positions.h"
#include "random_policy.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/verification/rounding_error.h"

namespace s2nnds {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWarnings =
    "-std=c++17 -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Werror";
constexpr const char* kFast = "-O3 -march=native";

// Every head, layers with and without biases, widths on and off the padding, a bottleneck.
Networks random_networks(int n, Activation activation, RandomStream& random) {
  Networks networks;
  networks.f = random_stack({n, 40, 17, n}, activation, true, false, random);
  networks.f.head = Head::zero_at_origin;
  networks.V = random_stack({n, 20, 7, 33, 9}, activation, true, false, random);
  networks.V.head = Head::squared_norm;
  networks.V.quadratic = 0.3;
  networks.B = random_stack({n, 16, 5, 1}, activation, false, false, random);
  return networks;
}

// What the compiled driver printed, row by row.
struct Answers {
  Points velocity;
  Vector lyapunov, barrier, safe;
  long allocations = -1;
};

class CppHeader : public testing::Test {
 protected:
  CppHeader() : folder_(fs::temp_directory_path() / ("s2nnds-cpp-header-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~CppHeader() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Whether the compiler takes `source` with the flags; its complaint is in errors().
  bool compile(const std::string& source, const std::string& flags) const {
    const std::string command =
        fmt::format("{} {} {} -I{} {} -o {} 2> {}", S2NNDS_CXX_COMPILER, kWarnings, flags, folder_.string(),
                    source, path("driver"), path("errors.txt"));
    return std::system(command.c_str()) == 0;
  }
  std::string errors() const {
    std::stringstream text;
    text << std::ifstream(path("errors.txt")).rdbuf();
    return text.str();
  }

  // The exported header's answers at x [N, n] in the data's unit.
  Answers ask(const Points& x, const std::string& flags) const {
    const std::string macros =
        fmt::format("'-DPOLICY_HEADER=\"policy.h\"' -DPOLICY_NAMESPACE=policy_policy {}", flags);
    if (!compile(S2NNDS_SOURCE_DIR "/tests/deployment/header_driver.cpp", macros)) fail("{}", errors());
    {
      std::ofstream points(path("points.txt"));
      for (Eigen::Index i = 0; i < x.size(); ++i) points << fmt::format("{:.17g}\n", x.data()[i]);
    }
    const std::string run =
        fmt::format("{} < {} > {}", path("driver"), path("points.txt"), path("results.txt"));
    check(std::system(run.c_str()) == 0, "the driver failed");
    return read_answers(x.rows(), x.cols());
  }

  Answers read_answers(Eigen::Index rows, Eigen::Index n) const {
    std::ifstream results(path("results.txt"));
    std::string word;
    const auto next = [&] {
      results >> word;
      return std::strtod(word.c_str(), nullptr);
    };
    Answers found{Points(rows, n), Vector(rows), Vector(rows), Vector(rows), -1};
    for (Eigen::Index i = 0; i < rows; ++i) {
      for (Eigen::Index d = 0; d < n; ++d) found.velocity(i, d) = next();
      found.lyapunov[i] = next();
      found.barrier[i] = next();
      found.safe[i] = next();
    }
    results >> found.allocations;
    return found;
  }

  // Velocities within `allowed` (normalised) of the double networks, V and B within rounding, safe where B <=
  // 0.
  void expect_same(const Networks& networks, HeaderPrecision precision, double allowed,
                   const std::string& flags) {
    const Eigen::Index n = networks.f.input_dimension();
    write_policy(networks, "header", path("policy.h"), precision);
    const Points z = Points::NullaryExpr(300, n, [&] { return random_.uniform(-1.25, 1.5); });
    const Answers found = ask(positions(z), flags);
    EXPECT_LE((found.velocity / 25.0 - networks.velocity(z)).rowwise().norm().maxCoeff(), allowed) << flags;
    const Vector lyapunov = networks.V.value(z).col(0), barrier = networks.B.value(z).col(0);
    EXPECT_LE((found.lyapunov - lyapunov).cwiseAbs().maxCoeff(), 1e-12 * lyapunov.cwiseAbs().maxCoeff())
        << flags;
    EXPECT_LE((found.barrier - barrier).cwiseAbs().maxCoeff(), 1e-12) << flags;
    for (Eigen::Index i = 0; i < z.rows(); ++i) EXPECT_EQ(found.safe[i] == 1.0, barrier[i] <= 0.0);
    EXPECT_EQ(found.allocations, 0) << flags;
  }
  double float_bound(const NetworkWeights& f) const {
    const Eigen::Index n = f.input_dimension();
    return float32_error(f, Box{Vector::Constant(n, -1.25), Vector::Constant(n, 1.5)});
  }

  fs::path folder_;
  RandomStream random_{11, "cpp header"};
};

class CppHeaderOf : public CppHeader, public testing::WithParamInterface<Activation> {};

TEST_P(CppHeaderOf, EvaluatesTheSameNetworksWithoutAllocating) {
  for (const int n : {2, 3}) {
    const Networks networks = random_networks(n, GetParam(), random_);
    expect_same(networks, HeaderPrecision::float32, float_bound(networks.f), n == 2 ? kFast : "-O1");
    expect_same(networks, HeaderPrecision::float64, 1e-13, n == 2 ? "-O2" : kFast);
  }
}

INSTANTIATE_TEST_SUITE_P(All, CppHeaderOf,
                         testing::Values(Activation::identity, Activation::tanh, Activation::elu,
                                         Activation::softplus, Activation::silu, Activation::sine),
                         [](const auto& each) { return std::string(to_string(each.param)); });

TEST_F(CppHeader, FloatStaysWithinTheCertificatesBoundNearlyTightly) {
  Networks networks = random_networks(2, Activation::tanh, random_);
  networks.f = random_stack({2, 64, 64, 64, 2}, Activation::tanh, true, false, random_);
  networks.f.head = Head::zero_at_origin;
  for (const char* flags : {"-O0", "-O2", kFast, "-O2 -DPOLICY_WITHOUT_VECTORS"}) {
    expect_same(networks, HeaderPrecision::float32, std::min(float_bound(networks.f), 5e-6), flags);
  }
}

// A projection never widens the distance of two velocities, so that f's bound applies.
TEST_F(CppHeader, AProjectedFIsProjectedInDouble) {
  for (const int n : {2, 7}) {
    for (const Activation activation : {Activation::tanh, Activation::elu}) {
      Networks networks = random_networks(n, activation, random_);
      networks.V = random_stack({n, 20, 33, n}, activation, true, false, random_);
      for (Layer& layer : networks.V.layers) layer.weight *= 0.4;
      networks.V.head = Head::diffeomorphism;
      networks.decay = 0.8;
      const Points z = Points::NullaryExpr(300, n, [&] { return random_.uniform(-1.25, 1.5); });
      EXPECT_GT((networks.velocity(z) - networks.f.value(z)).rowwise().norm().mean(), 0.1);
      expect_same(networks, HeaderPrecision::float32, float_bound(networks.f) * 1.01, n == 2 ? kFast : "-O1");
      expect_same(networks, HeaderPrecision::float64, 1e-12, n == 2 ? "-O2" : kFast);
      const Answers goal = ask(positions(Points::Zero(1, n)), kFast);
      EXPECT_LE(goal.velocity.norm(), 1e-12);
    }
  }
}

TEST_F(CppHeader, OneLayerAndThePapersForm) {
  Networks networks = random_networks(3, Activation::elu, random_);
  networks.f = random_stack({3, 64, 64, 3}, Activation::tanh, false, false, random_);
  networks.f.layers.back().activation = Activation::tanh;
  networks.V = random_stack({3, 1}, Activation::identity, false, false, random_);
  networks.B = random_stack({3, 16, 1}, Activation::elu, true, false, random_);
  networks.B.layers.back().activation = Activation::softplus;
  expect_same(networks, HeaderPrecision::float32, float_bound(networks.f), "-O2");
  expect_same(networks, HeaderPrecision::float64, 1e-13, "-O0");
}

// float32_error counts on eight units in the last place of 1.
TEST_F(CppHeader, TanhInFloatIsWithinWhatTheBoundAllows) {
  Networks networks = random_networks(2, Activation::tanh, random_);
  Layer layer;  // f(x) = tanh(x)
  layer.weight = Points::Identity(2, 2);
  layer.activation = Activation::tanh;
  networks.f = {};
  networks.f.layers = {layer};
  Policy policy = random_policy(networks);
  policy.info.goal = {0.0, 0.0};  // tiny distances from it are positions
  export_policy(policy, export_format_from("header"), {}, path("policy.h"));
  Points z(20000, 2);
  z.col(0).setLinSpaced(-12.0, 12.0);
  z.col(1) = (Vector::LinSpaced(z.rows(), -20.0, 2.0).array() * std::log(10.0)).exp();
  for (const char* flags : {"-O1", kFast}) {
    const Points error = ask(40.0 * z, flags).velocity / 25.0 - networks.f.value(z);
    EXPECT_LE(error.cwiseAbs().maxCoeff(), 16.0 * 0x1p-24) << flags;
    EXPECT_LE((error.col(1).array() / z.col(1).array()).abs().maxCoeff(), 16.0 * 0x1p-24) << flags;
  }
}

TEST_F(CppHeader, TheGoalIsAnEquilibriumExactly) {
  const Networks networks = random_networks(2, Activation::silu, random_);
  for (const HeaderPrecision precision : {HeaderPrecision::float32, HeaderPrecision::float64}) {
    write_policy(networks, "header", path("policy.h"), precision);
    for (const char* flags : {"-O0", kFast}) {
      const Answers found = ask(positions(Points::Zero(1, 2)), flags);
      EXPECT_EQ(found.velocity, Points::Zero(1, 2)) << flags;
      EXPECT_EQ(found.lyapunov[0], 0.0);
    }
  }
}

// Of states (x, s): s starts where the policy says, moves on by its rate times the period, and stays with the object.
TEST_F(CppHeader, KeepsAPhase) {
  Policy policy = random_policy(random_networks(3, Activation::tanh, random_));
  policy.info.phase_start = 425.0;
  export_policy(policy, export_format_from("header"), {HeaderPrecision::float64}, path("policy.h"));
  std::ofstream(path("phase.cpp")) << R"(#include "policy.h"
#include <cstdio>
int main() {
  policy_policy::PhasedMotion motion;
  const double x[2] = {520.0, -250.0};
  double v[2];
  for (int k = 0; k < 4; ++k) {
    motion.step(x, 0.01, v);
    std::printf("%.17g %.17g %.17g %d\n", v[0], v[1], motion.s, motion.safe(x) ? 1 : 0);
  }
}
)";
  ASSERT_TRUE(compile(path("phase.cpp"), "-O1")) << errors();
  ASSERT_EQ(std::system(fmt::format("{} > {}", path("driver"), path("results.txt")).c_str()), 0);
  std::ifstream results(path("results.txt"));
  double s = policy.info.phase_start;
  for (int k = 0; k < 4; ++k) {
    const Vector state{{520.0, -250.0, s}}, z = (state - far_goal(3)) / 40.0;
    const Vector rate = 25.0 * policy.networks.f.value(z.transpose()).row(0).transpose();
    double v0 = 0.0, v1 = 0.0, found = 0.0;
    int safe = -1;
    results >> v0 >> v1 >> found >> safe;
    EXPECT_NEAR(v0, rate[0], 1e-9);
    EXPECT_NEAR(v1, rate[1], 1e-9);
    s += 0.01 * rate[2];
    EXPECT_NEAR(found, s, 1e-9);
    const Vector after = (Vector{{520.0, -250.0, s}} - far_goal(3)) / 40.0;
    EXPECT_EQ(safe == 1, policy.networks.B.value(after.transpose())(0, 0) <= 0.0);
  }
}

TEST_F(CppHeader, NanStaysNanAndFarPointsStayFinite) {
  for (const Activation activation :
       {Activation::tanh, Activation::elu, Activation::softplus, Activation::silu}) {
    write_policy(random_networks(2, activation, random_), "header", path("policy.h"));
    const Answers found = ask(Points{{NAN, 0.0}, {0.0, NAN}, {1e9, -1e9}, {-1e9, 1e3}}, kFast);
    for (int i : {0, 1}) {
      EXPECT_TRUE(found.velocity.row(i).array().isNaN().all()) << to_string(activation);
      EXPECT_TRUE(std::isnan(found.lyapunov[i]) && std::isnan(found.barrier[i])) << to_string(activation);
      EXPECT_EQ(found.safe[i], 0.0);
    }
    EXPECT_TRUE(found.velocity.bottomRows(2).allFinite()) << to_string(activation);
  }
}

TEST_F(CppHeader, SafeIsTheSublevelSetOfTheBarrierWithinTheWorkspace) {
  Networks networks = random_networks(2, Activation::tanh, random_);
  Layer above;  // B(x, y) = y
  above.weight = Points{{0.0, 1.0}};
  networks.B = {};
  networks.B.layers = {above};
  write_policy(networks, "header", path("policy.h"));
  // Workspace [-50, 60]^2 around the goal.
  const Points from_goal{{10, -5}, {10, 5}, {10, -55}, {-55, -5}, {59, -5}, {61, -5}, {10, -1e-9}, {60, -50}};
  const Answers found = ask(positions(from_goal / 40.0), "-O2");
  const Vector expected{{1, 0, 0, 0, 1, 0, 1, 1}};
  EXPECT_EQ(found.safe, expected);
}

// On {B = 0}, where rounding decides.
TEST_P(CppHeaderOf, SafeIsNeverTrueWhereTheExactBarrierIsPositive) {
  const Networks networks = with_barrier(random_networks(2, Activation::tanh, random_), GetParam(), random_);
  const Policy policy = random_policy(networks);
  const Points x = boundary_positions(policy, 150, random_);
  write_policy(networks, "header", path("policy.h"));
  for (const char* flags : {"-O0", kFast}) {
    const Answers found = ask(x, flags);
    double largest = 0.0;
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      const Exact exact = exact_barrier(policy, x.row(i));
      EXPECT_FALSE(found.safe[i] == 1.0 && exact > 0) << flags << ' ' << i;
      largest = std::max(largest, std::abs(static_cast<double>(found.barrier[i] - exact)));
    }
    EXPECT_LE(largest, policy.info.barrier_float64_error) << flags;
    EXPECT_LE(policy.info.barrier_float64_error, 1e4 * largest) << flags;
  }
}

TEST_F(CppHeader, CarriesWhatIsGuaranteedOfWhichWeights) {
  const Networks networks = random_networks(3, Activation::tanh, random_);
  write_policy(networks, "header", path("policy.h"), HeaderPrecision::float64);
  write_policy(networks, "header", path("9 lives-x.h"));  // both in one program
  std::ofstream(path("main.cpp")) << fmt::format(R"(
#include "policy.h"
#include "9 lives-x.h"
#include <string_view>
namespace p = policy_policy;
static_assert(p::dimension == 3 && p::position_scale == 40.0 && p::velocity_scale == 25.0);
static_assert(std::string_view(p::name) == "Loop \"1\"\\" && std::string_view(p::unit) == "mm");
static_assert(std::string_view(p::guarantee) == "conformal" && std::string_view(p::weight_hash) == "{}");
static_assert(std::string_view(p::statement) == "Line one,\nline \"two\" ?" "?/ \\");
static_assert(p::workspace[0] == 462.0 && p::workspace[2] == 334.0 && p::workspace[3] == 572.0 && p::workspace[5] == 444.0);
static_assert(p::goal[0] == 512.0 && p::goal[2] == 384.0 && std::string_view(p::frame_name) == "base_link");
static_assert(std::string_view(p::unsafe_set) == "ball centre (1, 2) radius 3");
static_assert(p::disturbance_margin == 6.25 && p::float32_error == 2.5e-4 && p::convergence_radius == 3.5);
static_assert(std::string_view(p::precision) == "double");
static_assert(std::string_view(policy_9_lives_x::precision) == "float");
int main() {{}}
)",
                                                 weight_hash(networks));
  EXPECT_TRUE(compile(path("main.cpp"), "-O0")) << errors();
  EXPECT_FALSE(compile(path("main.cpp"), "-O2 -ffast-math"));
  EXPECT_NE(errors().find("without -ffast-math"), std::string::npos) << errors();
}

TEST_F(CppHeader, RefusesWhatItCannotWrite) {
  Networks networks = random_networks(2, Activation::tanh, random_);
  const auto refused = [&](const std::string& name, const std::string& words) {
    try {
      write_policy(networks, "header", path(name));
      ADD_FAILURE() << "expected an Error";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
    }
  };
  refused("nowhere/policy.h", "nowhere/policy.h: cannot write");
  networks.f.layers[1].weight(0, 0) = 1e300;
  refused("policy.h", "--precision double");
  EXPECT_TRUE(fs::is_empty(folder_));
  EXPECT_THROW(header_precision_from("half"), Error);
}

}  // namespace
}  // namespace s2nnds
