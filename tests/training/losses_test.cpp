#include <gtest/gtest.h>

#include "s2nnds/conditions/lie_derivative.h"
#include "s2nnds/training/joint_loss.h"

namespace s2nnds {
namespace {

struct Case {
  std::string activation;
  std::int64_t dimension;
  std::string loss;
  torch::Dtype dtype;
};

Modules make(const Case& c, Engine engine) {
  RandomStream random(3, "losses test");
  NetworkOptions options;
  if (c.loss == "paper") options = paper_networks();
  for (MlpOptions* network : {&options.f.network, &options.V.network, &options.B.network}) {
    network->hidden = {24, 17};
    network->activation = c.activation;
  }
  Modules modules;
  modules.f = VectorField(c.dimension, options.f, random, c.dtype);
  modules.V = Lyapunov(c.dimension, options.V, random, c.dtype);
  modules.B = Barrier(c.dimension, options.B, random, c.dtype);
  modules.f->network->engine = modules.V->network->engine = modules.B->network->engine = engine;
  return modules;
}

BatchTensors draw(const Case& c) {
  RandomStream random(4, "losses batch");
  const auto points = [&](std::int64_t count) {
    torch::Tensor x = torch::empty({count, c.dimension}, torch::kFloat64);
    for (std::int64_t i = 0; i < x.numel(); ++i) x.data_ptr<double>()[i] = random.uniform(-1.2, 1.2);
    return x.to(c.dtype);
  };
  return {points(70), points(70), points(130), points(30), points(50),
          points(60), points(0),  points(40),  points(40)};
}

struct Result {
  double loss;
  std::vector<torch::Tensor> gradients;
};

Result run(const Case& c, Engine engine) {
  Modules modules = make(c, engine);
  LossOptions options;
  options.kind = c.loss;
  options.weight[LossTerm::obstacle_normal] = 0.7;
  options.margin_obstacle_normal = 0.3;
  const LossValue loss = JointLoss(modules, options)(draw(c));
  loss.total.backward();
  return {
      loss.total.item<double>(),
      {modules.f->network->theta.grad(), modules.V->network->theta.grad(), modules.B->network->theta.grad()}};
}

class Engines : public testing::TestWithParam<Case> {};

// The fused engine against double backward: 1e-5 relative in float32, 1e-10 in float64.
TEST_P(Engines, AgreeOnLossAndGradients) {
  const Result fused = run(GetParam(), Engine::fused), reference = run(GetParam(), Engine::autograd);
  const double tolerance = GetParam().dtype == torch::kFloat64 ? 1e-10 : 1e-5;
  EXPECT_NEAR(fused.loss, reference.loss, tolerance * std::abs(reference.loss));
  for (std::size_t i = 0; i < fused.gradients.size(); ++i) {
    const double size = reference.gradients[i].norm().item<double>();
    ASSERT_GT(size, 0.0);
    EXPECT_LT((fused.gradients[i] - reference.gradients[i]).norm().item<double>(), tolerance * size)
        << "network " << i;
  }
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const char* activation : {"tanh", "elu", "softplus", "silu", "sine"}) {
    for (std::int64_t dimension : {2, 3, 5}) {
      for (const char* loss : {"robust", "paper"}) {
        for (torch::Dtype dtype : {torch::kFloat32, torch::kFloat64})
          all.push_back({activation, dimension, loss, dtype});
      }
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(All, Engines, testing::ValuesIn(cases()), [](const auto& test) {
  return test.param.activation + std::to_string(test.param.dimension) + test.param.loss +
         (test.param.dtype == torch::kFloat64 ? "Double" : "Float");
});

TEST(JointLoss, OfTheBarrierAloneHasTheSameGradientInB) {
  const Case c{"tanh", 2, "robust", torch::kFloat32};
  LossOptions options;
  options.weight[LossTerm::imitation] = options.weight[LossTerm::lyapunov] = 0.0;
  std::vector<torch::Tensor> of_B;
  for (const Trains trains : {Trains::all, Trains::barrier}) {
    Modules modules = make(c, Engine::fused);
    JointLoss(modules, options, trains)(draw(c)).total.backward();
    of_B.push_back(modules.B->network->theta.grad());
    EXPECT_EQ(modules.f->network->theta.grad().norm().item<double>() > 0.0, trains == Trains::all);
  }
  EXPECT_TRUE(torch::equal(of_B[0], of_B[1]));
}

// Else a network that has overflowed would look like one that meets every condition.
TEST(JointLoss, NotANumberGoesThrough) {
  for (const char* kind : {"robust", "paper"}) {
    for (int network = 0; network < 3; ++network) {
      const Case c{"tanh", 2, kind, torch::kFloat32};
      Modules modules = make(c, Engine::fused);
      torch::Tensor thetas[] = {modules.f->network->theta, modules.V->network->theta,
                                modules.B->network->theta};
      {
        torch::NoGradGuard no_grad;
        thetas[network].fill_(std::nan(""));
      }
      LossOptions options;
      options.kind = kind;
      EXPECT_TRUE(std::isnan(JointLoss(modules, options)(draw(c)).total.item<double>())) << kind << network;
    }
  }
}

// Where f = 0, the normal velocity lacks the whole margin.
TEST(RobustLoss, DeflectionIsWhatTheNormalVelocityLacks) {
  const Case c{"tanh", 2, "robust", torch::kFloat64};
  for (const Engine engine : {Engine::fused, Engine::autograd}) {
    Modules modules = make(c, engine);
    {
      torch::NoGradGuard no_grad;
      modules.f->network->theta.zero_();
    }
    BatchTensors batch = draw(c);
    batch.boundary = torch::tensor({{1.0, 0.3}, {-0.2, -1.0}}, c.dtype);
    batch.normal = torch::tensor({{1.0, 0.0}, {0.0, -1.0}}, c.dtype);
    LossOptions o;
    o.weight[LossTerm::obstacle_normal] = 2.0;
    o.margin_obstacle_normal = 0.3;
    EXPECT_NEAR(JointLoss(modules, o)(batch).terms[LossTerm::obstacle_normal], 2.0 * 0.3, 1e-12);
    batch.boundary = batch.normal = torch::Tensor();
    EXPECT_EQ(JointLoss(modules, o)(batch).terms[LossTerm::obstacle_normal], 0.0);
  }
}

// Equations (7) and (8) term by term on networks whose values are known: constants.
TEST(PaperLoss, MatchesTheFormulas) {
  const Case c{"tanh", 2, "paper", torch::kFloat64};
  Modules modules = make(c, Engine::fused);
  {
    torch::NoGradGuard no_grad;
    for (torch::Tensor theta :
         {modules.f->network->theta, modules.V->network->theta, modules.B->network->theta})
      theta.zero_();
    modules.B->network->theta[-1] = 0.7;  // B = 0.7 everywhere, f = 0, V = 0
  }
  LossOptions o;
  o.kind = "paper";
  o.margin_positive = 0.01;
  o.margin_decrease = 0.03;
  o.margin_initial = 0.02;
  o.margin_unsafe = 0.05;
  o.margin_barrier_decrease = 0.04;
  o.leak = 0.1;
  const LossValue loss = JointLoss(modules, o)(draw(c));
  EXPECT_NEAR(loss.terms[LossTerm::lyapunov], o.weight[LossTerm::lyapunov] * (0.01 + 0.1 * -0.03), 1e-12);
  EXPECT_NEAR(loss.terms[LossTerm::barrier_sets], o.weight[LossTerm::barrier_sets] * (0.72 + 0.1 * -0.65),
              1e-12);
  EXPECT_NEAR(loss.terms[LossTerm::barrier_decrease], o.weight[LossTerm::barrier_decrease] * (0.1 * -0.04),
              1e-12);
}

}  // namespace
}  // namespace s2nnds
