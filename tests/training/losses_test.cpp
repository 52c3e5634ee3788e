// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <torch/utils.h>

#include <cstdint>

#include "s2nnds/training/joint_loss.h"
#include "s2nnds/training/loss_obstacle_normal.h"
#include "s2nnds/training/loss_table.h"

namespace s2nnds {
namespace {

// Random networks of `dimension` inputs and a random batch, all drawn from one seed.
struct Case {
  Modules modules;
  BatchTensors batch;

  Case(std::uint64_t seed, bool paper, torch::Dtype dtype = torch::kFloat64,
       const std::string& activation = "", std::int64_t dimension = 0, bool stable = false) {
    RandomStream random(seed, "losses test");
    const auto between = [&](int low, int high) {
      return low + static_cast<std::int64_t>(random.below(static_cast<std::size_t>(high - low + 1)));
    };
    const std::vector<std::string> smooth = {"tanh", "softplus", "silu", "sine"};
    const std::int64_t n = dimension > 0 ? dimension : between(2, 4);
    NetworkOptions options = paper ? paper_networks() : NetworkOptions();
    if (stable) options.V.form = "diffeomorphism";
    for (MlpOptions* network : {&options.f.network, &options.V.network, &options.B.network}) {
      network->hidden.resize(between(1, 3));
      for (std::int64_t& width : network->hidden) width = between(3, 40);
      network->activation = activation.empty() ? smooth[random.below(smooth.size())] : activation;
    }
    modules.f = VectorField(n, options.f, random, dtype);
    modules.V = Lyapunov(n, options.V, random, dtype);
    modules.B = Barrier(n, options.B, random, dtype);
    const auto points = [&](std::int64_t count) {
      torch::Tensor x = torch::empty({count, n}, torch::kFloat64);
      for (std::int64_t i = 0; i < x.numel(); ++i) x.data_ptr<double>()[i] = random.uniform(-1.2, 1.2);
      return x.to(dtype);
    };
    const std::int64_t demonstrations = between(1, 120), boundary = between(1, 60);
    batch = {points(demonstrations), points(demonstrations), points(between(1, 150)),
             points(between(1, 60)), points(between(1, 60)), points(between(1, 60)),
             points(between(1, 60)), points(boundary),       points(boundary)};
  }

  std::vector<torch::Tensor> parameters() const {
    return {modules.f->network->theta, modules.V->network->theta, modules.B->network->theta};
  }

  LossValue loss(const LossTable& table, const LossOptions& options, Engine engine,
                 const Trains& trains = {}) const {
    return JointLoss(modules, table, options, engine, trains)(batch);
  }

  // The gradients in all parameters; zero where there is none.
  std::vector<torch::Tensor> gradients(const torch::Tensor& total) const {
    for (torch::Tensor& each : parameters()) each.mutable_grad() = torch::Tensor();
    if (total.requires_grad()) total.backward();
    std::vector<torch::Tensor> all;
    for (const torch::Tensor& each : parameters())
      all.push_back(each.grad().defined() ? each.grad().clone() : torch::zeros_like(each));
    return all;
  }
};

// A term of a test's own, of everything that the networks are at a sample: a new term is a penalty like this
// one and a line in a table.
struct ToyPenalty {
  static constexpr Quantities needs{.f = true, .V = true, .V_dot = true, .B = true, .B_dot = true};
  static constexpr Quantities constant{.V = true};

  static torch::Tensor values(const LossOptions&, const SampleTensors& at) {
    return at.f.square().sum(1) * at.V + at.V_dot * at.B + at.B_dot.square();
  }

  template <typename T>
  static double value(const LossOptions&, double weight, const Sample<T>& at) {
    double speed = 0.0;
    for (std::ptrdiff_t k = 0; k < at.dimension; ++k) {
      speed += static_cast<double>(at.f[k]) * static_cast<double>(at.f[k]);
      at.by_f[k] += static_cast<T>(2.0 * weight * at.V) * at.f[k];
    }
    at.by_V_dot += weight * at.B;
    at.by_B += weight * at.V_dot;
    at.by_B_dot += weight * 2.0 * at.B_dot;
    return speed * at.V + at.V_dot * at.B + at.B_dot * at.B_dot;
  }
};

LossOptions options_of(const std::string& kind) {
  LossOptions options;
  options.kind = kind;
  if (kind == "paper") options.leak = 0.1;
  return options;
}

// A robot that does all that a model can say, and a radius that some samples lie beyond.
ExecutionDemand demanding() {
  return {.model = {.period = 0.02,
                    .delay = 0.03,
                    .lag = 0.01,
                    .position_error = 0.02,
                    .velocity_error = 0.04,
                    .velocity_error_relative = 0.1,
                    .field_error = 0.01,
                    .least_speed = 0.8,
                    .most_speed = 0.8},
          .convergence_radius = 0.5};
}

// Every part of every table, and the toy.
struct PartCase {
  std::string name, kind;
  LossPart part;
};
std::vector<PartCase> every_part() {
  std::vector<PartCase> all;
  for (const std::string kind : {"robust", "paper"}) {
    for (const LossPart& part : loss_table(options_of(kind))) {
      all.push_back({kind + "_" + std::string(to_string(part.term)) + "_at_" +
                         std::to_string(static_cast<int>(part.samples)),
                     kind, part});
    }
  }
  all.push_back({"toy", "robust", loss_part<ToyPenalty>(LossTerm::barrier_sets, Samples::initial)});
  all.push_back({"paper_toy", "paper", loss_part<ToyPenalty>(LossTerm::lyapunov, Samples::workspace)});
  return all;
}

class EveryPart : public testing::TestWithParam<PartCase> {};

// Its mean by torch operations; what it holds constant is that of `held`.
double value_with(const LossPart& part, const LossOptions& options, Case& c, const SampleTensors& held) {
  SampleTensors at = quantities_at(c.modules, c.batch, part.samples, part.needs);
  if (part.constant.f) at.f = held.f;
  if (part.constant.V) at.V = held.V;
  if (part.constant.V_dot) at.V_dot = held.V_dot;
  if (part.constant.B) at.B = held.B;
  if (part.constant.B_dot) at.B_dot = held.B_dot;
  return options.weight[part.term] * part.values(options, at).mean().item<double>();
}

TEST_P(EveryPart, EnginesAndDifferencesAgreeOnRandomShapes) {
  const auto& [name, kind, part] = GetParam();
  LossOptions options = options_of(kind);
  options.weight = {};
  options.weight[part.term] = 1.7;
  double steepest = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Case c(seed, kind == "paper");
    const LossValue fused = c.loss({part}, options, Engine::fused),
                    reference = c.loss({part}, options, Engine::autograd);
    const double value = reference.terms[part.term];
    EXPECT_NEAR(fused.terms[part.term], value, 1e-10 * (1.0 + std::abs(value))) << seed;
    EXPECT_NEAR(fused.total.item<double>(), value, 1e-10 * (1.0 + std::abs(value))) << seed;
    const auto gradient = c.gradients(fused.total), expected = c.gradients(reference.total);
    const SampleTensors held = quantities_at(c.modules, c.batch, part.samples, part.needs);
    for (std::size_t network = 0; network < gradient.size(); ++network) {
      const double size = expected[network].norm().item<double>();
      EXPECT_LE((gradient[network] - expected[network]).norm().item<double>(), 1e-10 * (1.0 + size))
          << seed << " " << network;
      if (size == 0.0) continue;
      steepest = std::max(steepest, size);
      torch::Tensor theta = c.parameters()[network];
      const torch::Tensor direction = expected[network] / size, start = theta.detach().clone();
      const auto at = [&](double step) {
        {
          const torch::NoGradGuard no_grad;
          theta.copy_(start + step * direction);
        }
        return value_with(part, options, c, held);
      };
      const double h = 1e-6, slope = (at(h) - at(-h)) / (2.0 * h);
      at(0.0);
      EXPECT_NEAR(slope, size, 1e-4 * (1.0 + size)) << seed << " " << network;
    }
  }
  EXPECT_GT(steepest, 0.0) << "no case reaches this part";
}

INSTANTIATE_TEST_SUITE_P(Tables, EveryPart, testing::ValuesIn(every_part()),
                         [](const auto& test) { return test.param.name; });

struct EngineCase {
  std::string activation;
  std::int64_t dimension;
  std::string kind;
  torch::Dtype dtype;
  bool executed = false;
};

class Engines : public testing::TestWithParam<EngineCase> {};

// All terms together: 1e-5 relative in float32, 1e-10 in float64.
TEST_P(Engines, AgreeOnLossAndGradients) {
  const auto& [activation, dimension, kind, dtype, executed] = GetParam();
  LossOptions options = options_of(kind);
  if (executed) options.execution = demanding();
  options.weight[LossTerm::obstacle_normal] = 0.7;
  const Case c(3, kind == "paper", dtype, activation, dimension);
  const LossValue fused = c.loss(loss_table(options), options, Engine::fused),
                  reference = c.loss(loss_table(options), options, Engine::autograd);
  const double tolerance = dtype == torch::kFloat64 ? 1e-10 : 1e-5;
  const double value = reference.total.item<double>();
  EXPECT_NEAR(fused.total.item<double>(), value, tolerance * std::abs(value));
  for (const LossTerm term : all_loss_terms)
    EXPECT_NEAR(fused.terms[term], reference.terms[term], tolerance * std::abs(value)) << to_string(term);
  const auto gradient = c.gradients(fused.total), expected = c.gradients(reference.total);
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    const double size = expected[i].norm().item<double>();
    EXPECT_LE((gradient[i] - expected[i]).norm().item<double>(), tolerance * size) << "network " << i;
  }
}

std::vector<EngineCase> engine_cases() {
  std::vector<EngineCase> all;
  for (const char* activation : {"tanh", "elu", "softplus", "silu", "sine"}) {
    for (std::int64_t dimension : {2, 5}) {
      for (const char* kind : {"robust", "paper"}) {
        for (torch::Dtype dtype : {torch::kFloat32, torch::kFloat64}) {
          for (const bool executed : {false, true})
            all.push_back({activation, dimension, kind, dtype, executed});
        }
      }
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(All, Engines, testing::ValuesIn(engine_cases()), [](const auto& test) {
  return test.param.activation + std::to_string(test.param.dimension) + test.param.kind +
         (test.param.dtype == torch::kFloat64 ? "Double" : "Float") + (test.param.executed ? "Executed" : "");
});

struct StableCase {
  std::string activation;
  std::int64_t dimension;
  torch::Dtype dtype;
  double projection;
};

class StableEngines : public testing::TestWithParam<StableCase> {};

// The same with V a diffeomorphism, and B along the projected velocity.
TEST_P(StableEngines, AgreeOnLossAndGradients) {
  const auto& [activation, dimension, dtype, projection] = GetParam();
  LossOptions options;
  options.projection = projection;
  options.band_width = 2.0;
  options.decay_rate = 20.0;  // so that some samples break it, whatever the weights
  const double tolerance = dtype == torch::kFloat64 ? 1e-10 : 2e-5;
  for (const Trains& trains : {Trains{}, Trains::barrier(), Trains{.f = false, .V = true, .B = false},
                               Trains{.f = false, .V = true, .B = true}}) {
    const Case c(5, false, dtype, activation, dimension, true);
    const LossValue fused = c.loss(loss_table(options), options, Engine::fused, trains),
                    reference = c.loss(loss_table(options), options, Engine::autograd, trains);
    const double value = reference.total.item<double>();
    EXPECT_NEAR(fused.total.item<double>(), value, tolerance * std::abs(value));
    for (const LossTerm term : all_loss_terms)
      EXPECT_NEAR(fused.terms[term], reference.terms[term], tolerance * std::abs(value)) << to_string(term);
    const auto gradient = c.gradients(fused.total), expected = c.gradients(reference.total);
    const bool trained[] = {trains.f, trains.V, trains.B};
    for (std::size_t i = 0; i < gradient.size(); ++i) {
      if (!trained[i]) {
        EXPECT_EQ(gradient[i].norm().item<double>(), 0.0);
        continue;
      }
      const double size = expected[i].norm().item<double>();
      EXPECT_GT(size, 0.0);
      EXPECT_LE((gradient[i] - expected[i]).norm().item<double>(), tolerance * size) << "network " << i;
    }
    if (projection == 0.0 || !trains.B) continue;
    options.projection = 0.0;
    EXPECT_NE(c.loss(loss_table(options), options, Engine::fused, trains).terms[LossTerm::barrier_decrease],
              fused.terms[LossTerm::barrier_decrease]);
    options.projection = projection;
  }
}

std::vector<StableCase> stable_cases() {
  std::vector<StableCase> all;
  for (const char* activation : {"tanh", "elu", "softplus", "sine"}) {
    for (std::int64_t dimension : {2, 7}) {
      for (torch::Dtype dtype : {torch::kFloat32, torch::kFloat64}) {
        for (const double projection : {0.0, 20.0}) all.push_back({activation, dimension, dtype, projection});
      }
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(All, StableEngines, testing::ValuesIn(stable_cases()), [](const auto& test) {
  return test.param.activation + std::to_string(test.param.dimension) +
         (test.param.dtype == torch::kFloat64 ? "Double" : "Float") +
         (test.param.projection > 0.0 ? "Projected" : "");
});

// With what execution adds held constant, the gradients in V and B are those of the rates of the worst
// motions.
TEST(JointLoss, AsExecutedHasTheGradientOfTheWorstRate) {
  LossOptions options;
  options.weight = {};
  for (const LossTerm term : {LossTerm::lyapunov, LossTerm::barrier_decrease}) {
    options.weight[term] = 1.0;
    Case c(4, false, torch::kFloat64, "tanh", 2);
    const LossTable table = loss_table(options);
    const auto value = [&] { return c.loss(table, options, Engine::fused).total; };
    options.execution = {};
    const double ideal = value().item<double>();
    options.execution = demanding();
    EXPECT_GT(value().item<double>(), ideal * 1.01);
    const int network = term == LossTerm::lyapunov ? 1 : 2;
    const torch::Tensor gradient = c.gradients(value())[network];
    torch::Tensor theta = c.parameters()[network];
    const double size = gradient.norm().item<double>();
    const torch::Tensor direction = gradient / size, start = theta.detach().clone();
    // Of barrier_decrease's weight of the band, which is held constant, differences would see a change.
    if (term == LossTerm::barrier_decrease) options.band_width = 1e6;
    const torch::Tensor slope_there = c.gradients(value())[network];
    const auto at = [&](double step) {
      {
        const torch::NoGradGuard no_grad;
        theta.copy_(start + step * direction);
      }
      return value().item<double>();
    };
    const double h = 1e-6, slope = (at(h) - at(-h)) / (2.0 * h);
    at(0.0);
    EXPECT_NEAR(slope, (slope_there * direction).sum().item<double>(), 1e-5 * size);
    options.weight[term] = 0.0;
  }
}

TEST(JointLoss, OfTheBarrierAloneHasTheSameGradientInB) {
  const Case c(3, false, torch::kFloat32, "tanh", 2);
  LossOptions options;
  options.weight[LossTerm::imitation] = options.weight[LossTerm::lyapunov] =
      options.weight[LossTerm::obstacle_normal] = 0.0;
  const auto all = c.gradients(c.loss(loss_table(options), options, Engine::fused).total);
  const auto barrier =
      c.gradients(c.loss(loss_table(options), options, Engine::fused, Trains::barrier()).total);
  EXPECT_TRUE(torch::equal(all[2], barrier[2]));
  for (int network : {0, 1}) EXPECT_EQ(barrier[network].norm().item<double>(), 0.0);
  EXPECT_GT(all[0].norm().item<double>(), 0.0);
}

// Else a network that has overflowed would look like one that meets every condition.
TEST(JointLoss, NotANumberGoesThrough) {
  for (const char* kind : {"robust", "paper"}) {
    for (int network = 0; network < 3; ++network) {
      const Case c(3, false, torch::kFloat32, "tanh", 2);
      {
        const torch::NoGradGuard no_grad;
        c.parameters()[network].fill_(std::nan(""));
      }
      const LossOptions options = options_of(kind);
      const LossValue loss = c.loss(loss_table(options), options, Engine::fused);
      EXPECT_TRUE(std::isnan(loss.total.item<double>())) << kind << network;
    }
  }
}

// Where f = 0, the normal velocity lacks the whole margin.
TEST(ObstacleNormal, IsWhatTheNormalVelocityLacks) {
  Case c(3, false, torch::kFloat64, "tanh", 2);
  {
    const torch::NoGradGuard no_grad;
    c.modules.f->network->theta.zero_();
  }
  LossOptions options;
  options.weight[LossTerm::obstacle_normal] = 2.0;
  for (const Engine engine : {Engine::fused, Engine::autograd}) {
    c.batch.boundary = torch::tensor({{1.0, 0.3}, {-0.2, -1.0}}, torch::kFloat64);
    c.batch.normal = torch::tensor({{1.0, 0.0}, {0.0, -1.0}}, torch::kFloat64);
    const auto value = [&] {
      return c.loss(loss_table(options), options, engine).terms[LossTerm::obstacle_normal];
    };
    EXPECT_NEAR(value(), 2.0 * kObstacleNormalMargin, 1e-12);
    c.batch.boundary = c.batch.normal = torch::Tensor();
    EXPECT_EQ(value(), 0.0);
  }
}

// Equations (7) and (8) term by term on networks whose values are known: constants.
TEST(PaperLoss, MatchesTheFormulas) {
  const Case c(3, true, torch::kFloat64, "tanh", 2);
  {
    const torch::NoGradGuard no_grad;
    for (torch::Tensor& theta : c.parameters()) theta.zero_();
    c.modules.B->network->theta[-1] = 0.7;  // B = 0.7 everywhere, f = 0, V = 0
  }
  LossOptions o;
  o.kind = "paper";
  o.margin_positive = 0.01;
  o.margin_decrease = 0.03;
  o.margin_initial = 0.02;
  o.margin_unsafe = 0.05;
  o.margin_barrier_decrease = 0.04;
  o.leak = 0.1;
  const PerTerm<double> terms = c.loss(loss_table(o), o, Engine::fused).terms;
  EXPECT_NEAR(terms[LossTerm::lyapunov], o.weight[LossTerm::lyapunov] * (0.01 + 0.1 * -0.03), 1e-12);
  EXPECT_NEAR(terms[LossTerm::barrier_sets], o.weight[LossTerm::barrier_sets] * (0.72 + 0.1 * -0.65), 1e-12);
  EXPECT_NEAR(terms[LossTerm::barrier_decrease], o.weight[LossTerm::barrier_decrease] * (0.1 * -0.04), 1e-12);
}

}  // namespace
}  // namespace s2nnds
