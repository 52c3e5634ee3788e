// SPDX-License-Identifier: BSD-3-Clause
// The motion as a robot executes it: known answers, and motions with adversarial delays and errors.
#include "s2nnds/verification/executed_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/core/random.h"
#include "s2nnds/networks/evaluator.h"
#include "s2nnds/verification/polynomial_function.h"
#include "s2nnds/verification/supremum.h"
#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

Polynomial linear(double x, double y) {
  return Polynomial((Vector(2) << x, y).finished(), (Eigen::MatrixXi(2, 2) << 1, 0, 0, 1).finished());
}
Polynomial sum_of_squares(double constant) {
  return Polynomial((Vector(3) << 1.0, 1.0, constant).finished(),
                    (Eigen::MatrixXi(3, 2) << 2, 0, 0, 2, 0, 0).finished());
}

// xdot = A x with A = [-1, -turn; turn, -1], V = |x|^2, B = |x|^2 - 1.
ProofFunctions spiral(double turn) {
  return {std::make_shared<PolynomialFunction>(std::vector{linear(-1.0, -turn), linear(turn, -1.0)}),
          std::make_shared<PolynomialFunction>(std::vector{sum_of_squares(0.0)}),
          std::make_shared<PolynomialFunction>(std::vector{sum_of_squares(-1.0)})};
}

SafetyProblem plain_problem() {
  SafetyProblem problem;
  problem.workspace = Box::cube(2, 1.25);
  problem.initial = ball(Vector::Constant(2, 0.1), 0.1);
  problem.unsafe = empty_region(2);
  return problem;
}

bool invariant(const ExecutionModel& model, double turn = 0.0) {
  return prove_executed(spiral(turn), plain_problem(), model).invariant;
}

// On the circle, with unit normal n: n . f = -1, |J' n| = sqrt(1 + turn^2).
TEST(ExecutedMotion, IsCertifiedUpToTheKnownErrors) {
  EXPECT_TRUE(invariant({}));
  EXPECT_TRUE(invariant({.velocity_error = 0.97}));
  EXPECT_FALSE(invariant({.velocity_error = 1.01}));
  EXPECT_TRUE(invariant({.field_error = 0.97}));
  EXPECT_FALSE(invariant({.field_error = 1.01}));
  EXPECT_TRUE(invariant({.position_error = 0.97}));
  EXPECT_FALSE(invariant({.position_error = 1.01}));
  EXPECT_TRUE(invariant({.position_error = 0.97 / std::sqrt(5.0)}, 2.0));
  EXPECT_FALSE(invariant({.position_error = 1.01 / std::sqrt(5.0)}, 2.0));
  EXPECT_TRUE(invariant({.velocity_error_relative = 0.9}));
  EXPECT_FALSE(invariant({.velocity_error_relative = 1.01}));
}

// n . J xdot with xdot = A x: n' A^2 n = 1 - turn^2, so of a delay T about |1 - turn^2| T is lost.
TEST(ExecutedMotion, IsCertifiedUpToAboutTheKnownDelay) {
  EXPECT_TRUE(invariant({.delay = 0.25}));
  EXPECT_FALSE(invariant({.delay = 1.01}));
  EXPECT_TRUE(invariant({.period = 0.03, .delay = 0.03}, 2.0));
  EXPECT_FALSE(invariant({.period = 0.2, .delay = 0.14}, 2.0));
  EXPECT_TRUE(invariant({.lag = 0.3}));
  EXPECT_FALSE(invariant({.lag = 1.01}));
  const ExecutedMotion late = prove_executed(spiral(0.0), plain_problem(), {.delay = 1e6});
  EXPECT_FALSE(late.invariant);
  EXPECT_NE(late.reason, "");
}

// grad V . (f + delta) < 0 iff |x| > |delta|.
TEST(ExecutedMotion, ConvergesToTheBallWhereTheErrorsWin) {
  const ExecutedMotion found = prove_executed(spiral(0.0), plain_problem(), {.velocity_error = 0.2});
  EXPECT_TRUE(found.invariant);
  EXPECT_GE(found.convergence_radius, 0.2);
  EXPECT_LE(found.convergence_radius, 0.25);
  EXPECT_GE(found.most_command, 1.0);
  EXPECT_LE(found.most_command, 1.1);
}

TEST(ExecutedMotion, RefusesAModelOutOfRange) {
  EXPECT_THROW(invariant({.period = -1.0}), Error);
  EXPECT_THROW(invariant({.delay = std::nan("")}), Error);
  EXPECT_THROW(invariant({.least_speed = 0.0}), Error);
  EXPECT_THROW(invariant({.least_speed = 2.0}), Error);
}

// error / speed < 1: from `error` on.
TEST(CertifiedSpeeds, AreTheKnownOnes) {
  const SpeedRange range = certified_speeds(spiral(0.0), plain_problem(), {.velocity_error = 0.5});
  EXPECT_GE(range.least, 0.5);
  EXPECT_LE(range.least, 0.53);
  EXPECT_TRUE(std::isinf(range.most));
  const SpeedRange late = certified_speeds(spiral(0.0), plain_problem(), {.delay = 0.1});
  EXPECT_EQ(late.least, 0.0);
  EXPECT_GE(late.most, 2.0);
  EXPECT_LE(late.most, 10.0);
  EXPECT_GE(late.most_command, late.most);
  EXPECT_EQ(certified_speeds(spiral(0.0), plain_problem(), {.velocity_error = 1.01}).most, 0.0);
}

// ---- Motions

// Sampled-data motions of networks whose delays, errors, rounded readings and lag push outwards, along grad B.
class Adversary {
 public:
  Adversary(const Networks& networks, const ExecutionModel& model, std::uint64_t seed)
      : f_(networks.f), B_(networks.B), model_(model), random_(seed, "adversary", 0) {}

  // The largest B within `steps` periods from x, not counting the start. The errors are `times` what the model allows.
  double worst(Vector x, int steps, double times) {
    constexpr int substeps = 4;  // of a period
    std::vector<Vector> past(1, x);
    Vector v;  // what the arm tracks of the command
    double worst = -1e9;
    for (int step = 0; step < steps; ++step) {
      const Vector u = command(past, x, times, substeps);
      if (step == 0) v = u;
      const double noise = times * (model_.velocity_error + model_.velocity_error_relative * u.norm());
      const double h = model_.period / substeps, lag = times * model_.lag;
      for (int k = 0; k < substeps; ++k) {
        const Vector behind = v - u;  // falls with the lag, exactly
        const double kept = lag > 0.0 ? std::exp(-h / lag) : 0.0;
        x += h * (u + noise * normal(x)) + lag * (1.0 - kept) * behind;
        v = u + kept * behind;
        past.push_back(x);
        worst = std::max(worst, value(x));
      }
    }
    return worst;
  }
  double value(const Vector& x) const { return B_.value(x.transpose())(0, 0); }
  RandomStream& random() { return random_; }
  Vector normal(const Vector& x) const {
    Vector gradient(x.size());
    for (Eigen::Index d = 0; d < x.size(); ++d) {
      Points value, rate, direction = Points::Zero(1, x.size());
      direction(0, d) = 1.0;
      B_.value_and_derivative(x.transpose(), direction, value, rate);
      gradient(d) = rate(0, 0);
    }
    return gradient.normalized();
  }

 private:
  // Of the readings that the model allows, that whose command points outwards the most, from a few tries.
  Vector command(const std::vector<Vector>& past, const Vector& x, double times, int substeps) {
    const Vector n = normal(x);
    const auto oldest =
        static_cast<std::size_t>(std::floor(times * model_.delay / model_.period * substeps + 1e-9));
    Vector best;
    double farthest = -1e9;
    for (int k = 0; k < 12; ++k) {
      const std::size_t age =
          k % 3 == 0 ? 0
          : k % 3 == 1
              ? oldest
              : static_cast<std::size_t>(random_.uniform() * static_cast<double>(oldest + 1));  // samples ago
      const Vector& seen = age < past.size() ? past[past.size() - 1 - age] : past.front();
      const double angle = 2.0 * M_PI * random_.uniform();
      const Vector off = (Vector(2) << std::cos(angle), std::sin(angle)).finished();
      const double error = times * model_.position_error, grid = std::sqrt(2.0) * error;
      Vector y = seen + error * (k < 3 ? n : off);
      if (k >= 9 && grid > 0.0)
        y = grid * (seen / grid).array().round();  // rounded: off by grid / sqrt(2) at most
      Vector u = model_.most_speed * f_.value(y.transpose()).row(0).transpose();
      if (u.dot(n) > farthest) {
        farthest = u.dot(n);
        best = u;
      }
    }
    return best;
  }

  BasicEvaluator<double> f_, B_;
  ExecutionModel model_;
  RandomStream random_;
};

// The spiral of the hand-made barrier, and the largest model of this shape that is certified for it.
Networks turning_networks() {
  Networks networks = simple_networks();
  networks.f = linear_field((Points(2, 2) << -1.0, -0.3, 0.3, -1.0).finished());
  return networks;
}
ExecutionModel model_of_size(double size) {
  return {.period = 0.01 * size,
          .delay = 0.02 * size,
          .position_error = 0.02 * size,
          .velocity_error = 0.1 * size,
          .velocity_error_relative = 0.05 * size};
}
ExecutionModel lagging_model_of_size(double size) {
  ExecutionModel model = model_of_size(size);
  model.lag = 0.05 * size;
  return model;
}
using ModelOfSize = ExecutionModel (*)(double);
double largest_certified(const Networks& networks, const SafetyProblem& problem, ModelOfSize model) {
  double low = 0.0, high = 8.0;
  const ProofFunctions functions = ProofFunctions::of(networks);
  while (high - low > 0.02 * high) {
    const double middle = 0.5 * (low + high);
    (prove_executed_invariance(functions, problem, model(middle), 0).proved ? low : high) = middle;
  }
  return low;
}

// A point within 1e-3 of {B = 0}, inside.
Vector start_at_the_edge(Adversary& adversary) {
  const double angle = 2.0 * M_PI * adversary.random().uniform();
  const Vector ray = (Vector(2) << std::cos(angle), std::sin(angle)).finished();
  double low = 0.0, high = 1.25;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (low + high);
    (adversary.value(middle * ray) <= 0.0 ? low : high) = middle;
  }
  return (low - 1e-3 * adversary.random().uniform()) * ray;
}

int leaving(const Networks& networks, const ExecutionModel& model, double times, int motions) {
  Adversary adversary(networks, model, 7);
  int count = 0;
  for (int k = 0; k < motions; ++k) count += adversary.worst(start_at_the_edge(adversary), 10, times) > 0.0;
  return count;
}

TEST(ExecutedMotion, NoMotionLeavesUnderTheWorstThatIsCertified) {
  const Networks networks = turning_networks();
  for (const ModelOfSize model : {model_of_size, lagging_model_of_size}) {
    const double size = largest_certified(networks, simple_problem(), model);
    ASSERT_GT(size, 0.5);
    EXPECT_EQ(leaving(networks, model(size), 1.0, 1000), 0);
    // The bound is not idle; that of a lag is coarser.
    EXPECT_GT(leaving(networks, model(size), model == model_of_size ? 2.0 : 4.0, 200), 0);
  }
}

TEST(ExecutedMotion, DISABLED_NoneOfAMillionMotionsLeaves) {
  const Networks networks = turning_networks();
  for (const ModelOfSize model : {model_of_size, lagging_model_of_size}) {
    const double size = largest_certified(networks, simple_problem(), model);
    EXPECT_EQ(leaving(networks, model(size), 1.0, 500000), 0);
  }
}

// The bounds are the same on any number of threads.
TEST(ExecutedMotion, DoesNotDependOnTheNumberOfThreads) {
  const Networks networks = turning_networks();
  const ProofFunctions functions = ProofFunctions::of(networks);
  const auto found = [&](int threads) {
    use_threads(threads);
    const ExecutedMotion motion = prove_executed(functions, simple_problem(), model_of_size(0.5));
    const Shield shield = prove_shield(functions, simple_problem(), model_of_size(0.1));
    EXPECT_TRUE(motion.invariant);
    EXPECT_TRUE(shield.certified);
    return std::vector{motion.convergence_radius, motion.most_command, shield.band, shield.cone};
  };
  EXPECT_EQ(found(1), found(2));
}

// Over the disc |x| <= 1 and its circle, x0^2 is at most 1.
TEST(Supremum, IsTheKnownOne) {
  const ProofFunctions functions = spiral(0.0);
  const Box workspace = Box::cube(2, 1.25);
  const auto of = [&](BarrierSet set, double sign) {
    return supremum(functions, workspace, set, [=]() -> TileSize {
      return [=](const BoxTile& tile) {
        const TileRow low = tile.center[0] - tile.half[0], high = tile.center[0] + tile.half[0];
        const TileRow most = low.square().max(high.square()),
                      least = (low * high < 0.0).select(0.0, low.square().min(high.square()));
        return TileRow(sign > 0.0 ? most : TileRow(2.0 - least));
      };
    });
  };
  for (const BarrierSet set : {BarrierSet::inside, BarrierSet::level_set}) {
    for (const double sign : {1.0, -1.0}) {
      const double exact = sign > 0.0 ? 1.0 : 2.0;
      EXPECT_GE(of(set, sign), exact);
      EXPECT_LE(of(set, sign), 1.1 * exact);
    }
  }
  EXPECT_TRUE(std::isinf(supremum(functions, workspace, BarrierSet::inside, []() -> TileSize {
    return [](const BoxTile&) { return TileRow(TileRow::Constant(std::nan(""))); };
  })));
}

}  // namespace
}  // namespace s2nnds
