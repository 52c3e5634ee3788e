// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/prover.h"

#include <gtest/gtest.h>

#include <cfenv>
#include <cmath>
#include <limits>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/problem/region_sampler.h"
#include "s2nnds/verification/goal_neighbourhood.h"
#include "s2nnds/verification/network_function.h"
#include "tests/verification/exact_network.h"
#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

// Adds height * bump(x) to output `row` of a network whose layers are tanh, tanh, identity: bump is about 1
// on the cube of half-width `half` around `center` [n] and 0 outside.
NetworkWeights with_bump(const NetworkWeights& stack, Eigen::Index row, const Vector& center, double half,
                         double height) {
  NetworkWeights result = stack;
  const double gain = 4.0 / half;
  const Eigen::Index n = center.size();
  Layer &first = result.layers[0], &second = result.layers[1], &last = result.layers[2];
  const Eigen::Index a = first.weight.rows(), b = second.weight.rows();
  if (last.bias.size() == 0) last.bias = Vector::Zero(last.weight.rows());
  first.weight.conservativeResizeLike(Points::Zero(a + 2 * n, n));
  first.bias.conservativeResizeLike(Vector::Zero(a + 2 * n));
  second.weight.conservativeResizeLike(Points::Zero(b + 1, a + 2 * n));
  second.bias.conservativeResizeLike(Vector::Zero(b + 1));
  last.weight.conservativeResizeLike(Points::Zero(last.weight.rows(), b + 1));
  for (Eigen::Index i = 0; i < n; ++i) {
    for (int side = 0; side < 2; ++side) {
      const Eigen::Index unit = a + 2 * i + side;
      const double sign =
          side == 0 ? 1.0 : -1.0;  // tanh(g (x - c + half)) - tanh(g (x - c - half)) is 2 inside
      first.weight(unit, i) = gain;
      first.bias(unit) = gain * (sign * half - center[i]);
      second.weight(b, unit) = 5.0 * sign;
    }
  }
  second.bias(b) = 5.0 - 10.0 * static_cast<double>(n);  // the sum is 5 inside, at most -5 outside
  last.weight(row, b) = 0.5 * height;
  last.bias(row) += 0.5 * height;
  return result;
}
NetworkWeights with_bump(const NetworkWeights& stack, Eigen::Index row, double cx, double cy, double half,
                         double height) {
  return with_bump(stack, row, (Vector(2) << cx, cy).finished(), half, height);
}

// -x in effect, with the layers with_bump wants: -20 tanh(tanh(x / 20)).
NetworkWeights soft_stable_field(Eigen::Index n = 2) {
  const Points identity = Points::Identity(n, n);
  NetworkWeights f;
  f.layers = {layer(0.05 * identity, Vector::Zero(n), Activation::tanh),
              layer(identity, Vector::Zero(n), Activation::tanh),
              layer(-20.0 * identity, Vector::Zero(n), Activation::identity)};
  f.head = Head::zero_at_origin;
  return f;
}

ProofOptions quick() {
  ProofOptions options;
  options.max_boxes = 60000;
  options.max_seconds = 60.0;
  return options;
}

TEST(Prover, ProvesAStableLinearSystemInvariant) {
  const ProofResult result = prove(simple_networks(), simple_problem(), 0.01);
  for (const ConditionProof& proof : result.conditions) {
    EXPECT_TRUE(proof.is_proved()) << to_string(proof.verdict.condition) << ": "
                                   << to_string(proof.verdict.verdict);
    EXPECT_EQ(proof.open_lower.rows(), 0);
  }
  EXPECT_EQ(result.guarantee, Guarantee::invariant);
  EXPECT_TRUE(result.side.goal_is_safe);
  EXPECT_TRUE(result.side.initial_in_workspace);
  EXPECT_GT(result.goal_cube, 0.0);
  EXPECT_LT(result.boxes, 20000);
}

// Spirals and shears: V = |x|^2 decreases iff the symmetric part of A is negative definite.
TEST(Prover, DecidesLinearSystemsByTheirSymmetricPart) {
  for (double shear : {0.0, 1.0, 1.9, 2.1, 4.0}) {
    Networks networks = simple_networks();
    networks.f = linear_field((Points(2, 2) << -1.0, shear, 0.0, -1.0).finished());
    const ProofResult result = prove(networks, simple_problem(), 0.01, quick());
    EXPECT_EQ(result[Condition::lyapunov_decrease].is_proved(), shear < 2.0) << shear;
    EXPECT_EQ(result.goal_cube > 0.0, shear < 2.0) << shear;
  }
}

TEST(Prover, RefutesAnUnstableSystemWithAWitness) {
  Networks networks = simple_networks();
  networks.f = linear_field(Points::Identity(2, 2));
  const SafetyProblem problem = simple_problem();
  const ProofResult result = prove(networks, problem, 0.01, quick());
  EXPECT_EQ(result.guarantee, Guarantee::none);
  for (Condition condition : {Condition::lyapunov_decrease, Condition::barrier_decrease}) {
    const ConditionProof& proof = result[condition];
    EXPECT_EQ(proof.verdict.verdict, Verdict::refuted);
    ASSERT_EQ(proof.verdict.witness.size(), 2u);
    const Points at = residuals(networks, problem, 0.01, proof.witnesses);
    for (Eigen::Index i = 0; i < at.rows(); ++i) {
      EXPECT_TRUE(is_violated(condition, at(i, static_cast<Eigen::Index>(condition))));
    }
    EXPECT_GT(proof.verdict.open_boxes, 0);
    EXPECT_GT(proof.verdict.open_volume, 0.0);
  }
  EXPECT_TRUE(result[Condition::initial].is_proved());
}

TEST(Prover, SeesABarrierCrossedInASetOfMeasure1e8) {
  // On the x axis, where B = 0.
  double low = 0.5, high = 1.2;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const Points x = (Points(1, 2) << middle, 0.0).finished();
    (square_barrier().value(x)(0, 0) < 0.0 ? low : high) = middle;
  }
  Networks networks = simple_networks();
  networks.f = soft_stable_field();
  EXPECT_EQ(prove(networks, simple_problem(), 1e-3, quick()).guarantee, Guarantee::invariant);
  networks.f = with_bump(networks.f, 0, low, 0.0, 0.5e-4, 3.0);
  const ProofResult result = prove(networks, simple_problem(), 1e-3, quick());
  EXPECT_EQ(result[Condition::barrier_decrease].verdict.verdict, Verdict::refuted);
  EXPECT_LT(result[Condition::barrier_decrease].verdict.open_volume, 1e-6);
}

TEST(Prover, SeesAHoleOfMeasure1e8InTheUnsafeSet) {
  Networks networks = simple_networks();
  networks.B = with_bump(networks.B, 0, 1.07, 1.02, 0.5e-4, -3.0);
  const ProofResult result = prove(networks, simple_problem(), 0.01, quick());
  EXPECT_EQ(result[Condition::unsafe].verdict.verdict, Verdict::refuted);
  EXPECT_TRUE(result[Condition::initial].is_proved());
}

// B is a plane past a ball; boxes that straddle the ball's boundary need not be as small as the gap.
TEST(Prover, ABarrierThatGrazesABallTakesFewBoxes) {
  const Vector normal = Vector{{0.6, -0.8}}, center = Vector{{-0.6, 0.7}};
  SafetyProblem problem = simple_problem();
  problem.unsafe = ball(center, 0.25);
  for (const double gap : {1e-5, -1e-5}) {
    NetworkWeights plane;
    const double nearest = normal.dot(center) - 0.25;
    plane.layers = {layer(normal.transpose(), Vector::Constant(1, gap - nearest), Activation::identity)};
    Networks networks = simple_networks();
    networks.B = plane;
    const ConditionProof proof =
        prove_condition(Condition::unsafe, ProofFunctions::of(networks), problem, 0.01, quick());
    EXPECT_EQ(proof.verdict.verdict, gap > 0.0 ? Verdict::proved : Verdict::refuted) << gap;
    if (gap > 0.0) {
      EXPECT_LT(proof.verdict.boxes, 200);
    }
  }
}

TEST(Prover, SeesAViolationOnlyAtTheWorkspacesEdge) {
  Networks networks = simple_networks();
  networks.f = with_bump(soft_stable_field(), 0, 1.25, 0.3, 1e-5, 3.0);
  ProofResult result = prove(networks, simple_problem(), 0.01, quick());
  EXPECT_EQ(result[Condition::lyapunov_decrease].verdict.verdict, Verdict::refuted);
  // The same outside of the workspace does no harm.
  networks.f = with_bump(soft_stable_field(), 0, 1.2502, 0.3, 1e-5, 3.0);
  result = prove(networks, simple_problem(), 0.01, quick());
  EXPECT_TRUE(result[Condition::lyapunov_decrease].is_proved());

  // {B <= 0} reaching the boundary at one spot, without a margin.
  SafetyProblem open_problem = simple_problem();
  open_problem.workspace_margin = nullptr;
  networks = simple_networks();
  EXPECT_EQ(prove(networks, open_problem, 0.01, quick()).guarantee, Guarantee::invariant);
  networks.B = with_bump(networks.B, 0, -0.4, -1.25, 1e-5, -3.0);
  result = prove(networks, open_problem, 0.01, quick());
  EXPECT_EQ(result[Condition::containment].verdict.verdict, Verdict::refuted);
  EXPECT_NE(result.guarantee, Guarantee::invariant);
}

// In four dimensions boxes are looked at only where a condition asks for something: nothing that it asks for may be lost.
TEST(Prover, InFourDimensionsSeesSmallViolationsOfEachCondition) {
  const SafetyProblem problem = simple_problem(4);
  ProofOptions options = quick();
  options.max_boxes = 1000000;
  const Networks sound = {soft_stable_field(4), quadratic_lyapunov(4), square_barrier(4)};
  const ProofResult whole = prove(sound, problem, 1e-3, options);
  EXPECT_EQ(whole.guarantee, Guarantee::invariant);
  const auto at = [](double x, double y, double z, double w) { return (Vector(4) << x, y, z, w).finished(); };
  const auto expect_seen = [&](Condition condition, const Networks& networks) {
    const ConditionProof proof =
        prove_condition(condition, ProofFunctions::of(networks), problem, 1e-3, options);
    EXPECT_EQ(proof.verdict.verdict, Verdict::refuted) << to_string(condition);
    EXPECT_GE(proof.verdict.boxes, 1);
  };
  const auto with_hole = [&](const Vector& center, double height) {
    Networks networks = sound;
    networks.B = with_bump(sound.B, 0, center, 2e-3, height);
    return networks;
  };
  // Just within the sets, and far from their middle.
  expect_seen(Condition::initial, with_hole(at(0.3, -0.2 + 0.197, 0.0, 0.0), 3.0));
  expect_seen(Condition::unsafe, with_hole(at(1.05, 1.05, 0.0, -0.097), -3.0));
  expect_seen(Condition::containment, with_hole(at(0.2, 0.97 * 1.25 + 3e-3, 0.1, -0.3), -3.0));
  expect_seen(Condition::containment, with_hole(at(0.2, -0.1, 0.7, -1.249), -3.0));
  // On the x axis, where B = 0.
  double low = 0.5, high = 1.2;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (sound.B.value(at(middle, 0.0, 0.0, 0.0).transpose())(0, 0) < 0.0 ? low : high) = middle;
  }
  Networks networks = sound;
  networks.f = with_bump(sound.f, 0, at(low, 0.0, 0.0, 0.0), 2e-3, 3.0);
  expect_seen(Condition::barrier_decrease, networks);
}

TEST(Prover, SeesAViolationOnly1e6FromTheGoal) {
  // -x + 2e-6 tanh(1e6 x): unstable within 2e-6 of the goal, stable beyond.
  Points inner = Points::Zero(4, 2), outer = Points::Zero(2, 4);
  for (int i = 0; i < 2; ++i) {
    inner(i, i) = 0.01;
    inner(2 + i, i) = 1e6;
    outer(i, i) = -100.0;
    outer(i, 2 + i) = 2e-6;
  }
  Networks networks = simple_networks();
  networks.f.layers = {layer(inner, Vector(), Activation::tanh),
                       layer(outer, Vector(), Activation::identity)};
  const ProofResult result = prove(networks, simple_problem(), 0.01, quick());
  const ConditionProof& decrease = result[Condition::lyapunov_decrease];
  EXPECT_EQ(decrease.verdict.verdict, Verdict::refuted);
  EXPECT_EQ(result.goal_cube, 0.0);
  EXPECT_LT(decrease.open_upper.cwiseAbs().maxCoeff(), 1e-5);
}

// A bias-free V has V < 0 next to the goal unless its gradient happens to vanish there.
TEST(Prover, FindsWhereThePapersLyapunovFunctionIsNegative) {
  RandomStream random(3, "paper");
  Networks networks = simple_networks();
  networks.V = random_stack({2, 8, 8, 1}, Activation::elu, Head::plain, random);
  for (Layer& each : networks.V.layers) each.bias = Vector();
  const ProofResult result = prove(networks, simple_problem(), 0.01, ProofOptions::fail_fast());
  const ConditionProof& positive = result[Condition::lyapunov_positive];
  ASSERT_EQ(positive.verdict.verdict, Verdict::refuted);
  EXPECT_LT(networks.V.value(positive.witnesses.topRows(1))(0, 0), 0.0);
}

TEST(Prover, SaysWhenTheGoalOrTheInitialSetIsNotSafe) {
  Networks networks = simple_networks();
  networks.B = with_bump(networks.B, 0, 0.0, 0.0, 1e-4, 3.0);
  EXPECT_FALSE(prove(networks, simple_problem(), 0.01, quick()).side.goal_is_safe);

  SafetyProblem outside = simple_problem();
  outside.initial = ball((Vector(2) << 1.2, 0.0).finished(), 0.1);
  const ProofResult result = prove(simple_networks(), outside, 0.01, quick());
  EXPECT_FALSE(result.side.initial_in_workspace);
  EXPECT_EQ(result[Condition::initial].verdict.verdict, Verdict::refuted);
}

// f is -x but for a factor of a few times the smallest number, V and B are scaled up: what underflow loses in f is then
// worth more than f itself.
TEST(Prover, UnderflowInOneLayerIsNotMagnifiedIntoAProof) {
  constexpr double tiny = std::numeric_limits<double>::denorm_min();
  Networks networks = simple_networks();
  networks.f.layers = {layer((Points(2, 2) << 0.5, 0.3, -0.3, 0.5).finished(), Vector(), Activation::tanh),
                       layer((Points(2, 2) << -60 * tiny, tiny, -tiny, -31 * tiny).finished(), Vector(),
                             Activation::identity)};
  networks.V.layers.front().weight *= 1e150;
  networks.B.layers.back().weight *= 1e140;
  const ProofResult result = prove(networks, simple_problem(), 0.01, quick());
  EXPECT_EQ(result.guarantee, Guarantee::none);
  for (const ConditionProof& proof : result.conditions) {
    if (proof.verdict.condition == Condition::lyapunov_positive) continue;  // left to the reason as well
    EXPECT_EQ(proof.verdict.verdict, Verdict::undecided) << to_string(proof.verdict.condition);
    EXPECT_NE(proof.verdict.reason, "");
  }
}

// All weights are normal numbers; the product of two layers is lost in between.
TEST(Prover, UnderflowBetweenTwoLinearLayersIsNotMagnifiedIntoAProof) {
  Networks networks = simple_networks();
  networks.f.layers = {
      layer(1e-164 * (Points(2, 2) << -1, 0.4, -0.4, -1).finished(), Vector(), Activation::identity),
      layer(1e-160 * Points::Identity(2, 2), Vector(), Activation::identity),
      layer(1e150 * Points::Identity(2, 2), Vector(), Activation::identity)};
  networks.V.layers.front().weight *= 1e100;
  EXPECT_EQ(prove(networks, simple_problem(), 0.01, quick()).guarantee, Guarantee::none);
  // Within the range, a field this slow is not proved either: the bounds leave room for underflow.
  networks = simple_networks();
  networks.f = linear_field(-1e-100 * Points::Identity(2, 2));
  const ProofResult slow = prove(networks, simple_problem(), 0.01, quick());
  EXPECT_EQ(slow[Condition::barrier_decrease].verdict.verdict, Verdict::undecided);
}

TEST(Prover, WorksTheSameWithFlushToZeroAndAnyRoundingMode) {
  const auto boxes = [] {
    std::vector<std::int64_t> found;
    for (const ConditionProof& proof : prove(simple_networks(), simple_problem(), 0.01).conditions) {
      EXPECT_TRUE(proof.is_proved());
      found.push_back(proof.verdict.boxes);
    }
    return found;
  };
  const std::vector<std::int64_t> expected = boxes();
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    std::fesetround(mode);
    const auto found = boxes();
    EXPECT_EQ(std::fegetround(), mode);
    std::fesetround(FE_TONEAREST);
    EXPECT_EQ(found, expected);
  }
#if defined(__SSE2__)
  const unsigned before = _mm_getcsr();
  _mm_setcsr(before | 0x8040u);  // flush to zero, denormals are zero
  const auto found = boxes();
  EXPECT_EQ(_mm_getcsr() & 0x8040u, 0x8040u);
  _mm_setcsr(before);
  EXPECT_EQ(found, expected);
#endif
}

// The conditions hold away from the goal, but the motion drifts past it.
TEST(Prover, ADriftThroughTheGoalIsNotProved) {
  SafetyProblem problem = simple_problem();
  problem.workspace_margin = nullptr;
  Networks networks = simple_networks();
  networks.f.layers = {layer(Points::Zero(2, 2), (Vector(2) << 1, 0).finished(), Activation::identity)};
  networks.f.head = Head::plain;
  networks.V.layers = {
      layer((Points(1, 2) << -1, 0).finished(), Vector::Constant(1, 10.0), Activation::identity)};
  networks.V.head = Head::plain;
  networks.V.quadratic = 0.0;
  const ProofResult result = prove(networks, problem, 0.01, quick());
  EXPECT_TRUE(result[Condition::lyapunov_decrease].is_proved());
  EXPECT_FALSE(result.side.goal_is_equilibrium);
  EXPECT_FALSE(result.side.lyapunov_vanishes_at_goal);
  EXPECT_EQ(result.guarantee, Guarantee::none);
}

TEST(Prover, NotANumberIsNeverProved) {
  Networks networks = simple_networks();
  networks.f = linear_field(-1e308 * Points::Ones(2, 2));
  networks.B.layers[0].weight.setConstant(1e308);
  networks.B.layers[1].weight.setConstant(1e308);
  ProofOptions options = quick();
  options.max_boxes = 2000;
  const ProofResult result = prove(networks, simple_problem(), 0.01, options);
  EXPECT_EQ(result[Condition::barrier_decrease].verdict.verdict, Verdict::undecided);
  EXPECT_EQ(result.guarantee, Guarantee::none);
}

TEST(Prover, DoesNotDependOnTheNumberOfThreads) {
  RandomStream random(4, "threads");
  for (int k = 0; k < 3; ++k) {
    Networks networks = {random_stack({2, 12, 12, 2}, Activation::tanh, Head::zero_at_origin, random),
                         random_stack({2, 12, 8}, Activation::tanh, Head::squared_norm, random),
                         random_stack({2, 12, 12, 1}, Activation::tanh, Head::plain, random)};
    ProofOptions options = ProofOptions::fail_fast();
    options.max_boxes = 30000;
    options.max_seconds = 1e6;
    use_threads(1);
    const ProofResult one = prove(networks, simple_problem(), 0.02, options);
    use_threads(2);
    const ProofResult two = prove(networks, simple_problem(), 0.02, options);
    EXPECT_EQ(one.boxes, two.boxes);
    for (Condition condition : all_conditions) {
      EXPECT_EQ(one[condition].verdict.verdict, two[condition].verdict.verdict);
      EXPECT_EQ(one[condition].verdict.boxes, two[condition].verdict.boxes);
      EXPECT_EQ(one[condition].verdict.open_boxes, two[condition].verdict.open_boxes);
      EXPECT_EQ(one[condition].verdict.witness, two[condition].verdict.witness);
      EXPECT_EQ(one[condition].open_lower, two[condition].open_lower);
    }
  }
}

TEST(Prover, ReturnsSamplesOfOpenBoxes) {
  Networks networks = simple_networks();
  networks.f = linear_field(Points::Identity(2, 2));
  const ProofResult result = prove(networks, simple_problem(), 0.01, ProofOptions::fail_fast());
  RandomStream random(5, "open");
  const ConditionProof& open = result[Condition::barrier_decrease];
  const Points samples = open.samples(500, random);
  ASSERT_EQ(samples.rows(), 500);
  EXPECT_LE(samples.cwiseAbs().maxCoeff(), 1.25);
  EXPECT_EQ(samples.row(0), open.witnesses.row(0));
  EXPECT_EQ(result[Condition::initial].samples(10, random).rows(), 0);
}

TEST(Prover, StopsAtItsLimits) {
  Networks networks = simple_networks();
  networks.f = linear_field((Points(2, 2) << -1.0, 2.0, 0.0, -1.0).finished());  // Vdot = 0 along a line
  ProofOptions options;
  options.max_boxes = 1000;
  const ProofResult result = prove(networks, simple_problem(), 0.01, options);
  EXPECT_LE(result[Condition::lyapunov_decrease].verdict.boxes, 1000);
  EXPECT_EQ(result[Condition::lyapunov_decrease].verdict.verdict, Verdict::undecided);
  options.max_boxes = 100000000;
  options.max_seconds = 0.3;
  const ProofResult timed = prove(networks, simple_problem(), 0.01, options);
  EXPECT_LT(timed.seconds, 10.0);
  EXPECT_FALSE(timed[Condition::lyapunov_decrease].is_proved());
}

TEST(Prover, RejectsWhatDoesNotFit) {
  Networks networks = simple_networks();
  EXPECT_THROW(prove(networks, simple_problem(), -1.0), Error);
  networks.B =
      random_stack({3, 4, 1}, Activation::tanh, Head::plain, *std::make_unique<RandomStream>(1, "misfit"));
  EXPECT_THROW(prove(networks, simple_problem(), 0.01), Error);
}

// Ascends the residual from the worst of many points; what it finds must never have been called proved.
double largest_residual(const Networks& networks, const SafetyProblem& problem, double level_band,
                        Condition condition) {
  RandomStream random(7, "largest residual");
  const Points x = uniform_points(problem.workspace, 6400, random);
  const auto column = static_cast<Eigen::Index>(condition);
  Eigen::Index at = 0;
  double best = residuals(networks, problem, level_band, x).col(column).maxCoeff(&at);
  Points point = x.row(at);
  for (double step = 0.02; step > 1e-6; step *= 0.7) {
    Points around = point.replicate(8, 1);
    for (double& coordinate : around.reshaped()) coordinate += step * random.uniform(-1.0, 1.0);
    around = around.cwiseMax(-1.25).cwiseMin(1.25);
    const double found = residuals(networks, problem, level_band, around).col(column).maxCoeff(&at);
    if (found > best) {
      best = found;
      point = around.row(at);
    }
  }
  return best;
}

void expect_mutants_to_be_seen(Eigen::Index n, int mutants, std::int64_t boxes) {
  const SafetyProblem problem = simple_problem(n);
  RandomStream random(6, "mutants");
  int proved = 0, refuted = 0;
  for (int k = 0; k < mutants; ++k) {
    Networks networks = {soft_stable_field(n), quadratic_lyapunov(n), square_barrier(n)};
    const double noise = 0.02 * std::pow(1.16, k * 30.0 / mutants);
    for (NetworkWeights* stack : {&networks.f, &networks.V, &networks.B}) {
      for (Layer& each : stack->layers) {
        for (double& w : each.weight.reshaped()) w *= 1.0 + noise * random.normal();
        for (double& b : each.bias) b += 0.1 * noise * random.normal();
      }
    }
    ProofOptions options = ProofOptions::fail_fast();
    options.max_boxes = boxes;
    const ProofResult result = prove(networks, problem, 0.02, options);
    for (Condition condition : all_conditions) {
      const bool violated = is_violated(condition, largest_residual(networks, problem, 0.02, condition));
      EXPECT_FALSE(violated && result[condition].is_proved()) << to_string(condition) << " mutant " << k;
      proved += result[condition].is_proved();
      refuted += violated;
    }
  }
  EXPECT_GT(3 * proved, 4 * mutants);
  EXPECT_GT(3 * refuted, mutants);
}

TEST(Prover, NeverProvesMutatedNetworksThatASearchRefutes) { expect_mutants_to_be_seen(2, 30, 8000); }
TEST(Prover, NeverProvesMutatedNetworksInFourDimensions) { expect_mutants_to_be_seen(4, 15, 200000); }

TEST(GoalNeighbourhood, FollowsTheLinearisation) {
  const NetworkFunction lyapunov(quadratic_lyapunov());
  EXPECT_GT(decreasing_cube(NetworkFunction(stable_field()), lyapunov, 0.05), 0.0);
  EXPECT_EQ(decreasing_cube(NetworkFunction(linear_field(Points::Identity(2, 2))), lyapunov, 0.05), 0.0);
  EXPECT_GT(positive_cube(lyapunov, 0.05), 0.0);
}

TEST(IntervalMatrix, DefinitenessIsDecidedForWholeIntervals) {
  IntervalMatrix a(2, 2);
  a(0, 0) = a(1, 1) = Interval(1.0, 1.1);
  a(0, 1) = a(1, 0) = Interval(-0.9, 0.9);
  EXPECT_TRUE(is_positive_definite(a));
  a(0, 1) = a(1, 0) = Interval(-0.9, 1.01);
  EXPECT_FALSE(is_positive_definite(a));
  // Only the symmetric part counts.
  a(0, 1) = Interval(50.0, 50.1);
  a(1, 0) = Interval(-50.1, -50.0);
  EXPECT_TRUE(is_positive_definite(a));
  a(1, 1) = Interval(std::nan(""), std::nan(""));
  EXPECT_FALSE(is_positive_definite(a));
}

}  // namespace
}  // namespace s2nnds
