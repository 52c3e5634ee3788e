// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/trainer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>

#include "s2nnds/core/check.h"
#include "s2nnds/data/frame.h"
#include "s2nnds/data/handwriting.h"
#include "s2nnds/data/phase.h"
#include "s2nnds/evaluation/rollout.h"
#include "s2nnds/training/falsifier.h"

namespace s2nnds {
namespace {

// A small problem: handwriting with a ball beside it.
struct Fixture {
  Frame frame;
  std::vector<Demonstration> demonstrations;
  SafetyProblem problem;
  NetworkOptions networks;
  TrainerOptions options;

  Fixture() {
    const DemonstrationSet set = handwriting("Sine");
    frame = find_frame(set, "max_abs", {"each"});
    demonstrations = frame.normalize(set.demonstrations);
    ProblemOptions p;
    p.frame = "normalised";
    p.unsafe.type = "ball";
    p.unsafe.center = {-0.32, 0.22};
    p.unsafe.radius = 0.1;
    problem = make_problem(p, demonstrations, frame);
    networks.f.network.hidden = networks.B.network.hidden = {16, 16};
    networks.V.network.hidden = {16};
    networks.V.features = 8;
    options.warm_start.steps = 200;
    options.rounds = 4;
    options.min_rounds = 4;
    options.steps = 20;
    options.rollout_points = 200;
    options.samples = 2000;
  }

  Trainer trainer(std::uint64_t seed) {
    Trainer made(problem, demonstrations, networks, options, seed);
    made.add_source(std::make_shared<RandomFalsifier>(problem, FalsifierOptions{options.samples, 100}));
    made.set_rollout_labels(
        [this](const Dynamics& f, const Points& x) { return rollout_is_safe(f, problem, x); });
    return made;
  }
};

TEST(Trainer, SameSeedSameNetworksOtherSeedOthers) {
  Fixture fixture;
  const auto hash = [&](std::uint64_t seed) {
    Trainer trainer = fixture.trainer(seed);
    trainer.run();
    return weight_hash(trainer.networks());
  };
  const std::string first = hash(5);
  EXPECT_EQ(first, hash(5));
  EXPECT_NE(first, hash(6));
}

TEST(Trainer, GoesOnFromAnyRoundAsIfItHadNeverStopped) {
  Fixture fixture;
  std::vector<TrainerState> states;
  Trainer unbroken = fixture.trainer(5);
  unbroken.on_round([&](const RoundSummary&, const Trainer& t) {
    states.push_back(t.state());
    return true;
  });
  const TrainerSummary summary = unbroken.run();
  ASSERT_EQ(states.size(), 5U);  // warm start and four rounds
  for (std::size_t round : {0, 2, 4}) {
    Trainer resumed = fixture.trainer(5);
    resumed.restore(states[round]);
    EXPECT_EQ(resumed.run().rounds, summary.rounds);
    EXPECT_EQ(weight_hash(resumed.networks()), weight_hash(unbroken.networks())) << "from round " << round;
  }
}

// Finds something in the rounds it is told.
class ScriptedSource : public CounterexampleSource {
 public:
  explicit ScriptedSource(std::set<std::int64_t> rounds) : rounds_(std::move(rounds)) {}
  Counterexamples find(const Networks&, const SafetyProblem& problem, double, std::uint64_t,
                       std::int64_t round) override {
    Counterexamples found;
    for (Points& points : found.points) points.resize(0, problem.dimension());
    if (rounds_.count(round) == 0) return found;
    found.points.front() = Points::Constant(1, problem.dimension(), 0.5);
    found.counts.front() = found.samples.front() = 1;
    return found;
  }

 private:
  std::set<std::int64_t> rounds_;
};

// After the first clean round, rounds that fine-tune move all three networks, then those that enlarge the
// safe set move B alone, and only to where it is clean again.
TEST(Trainer, FineTunesThenEnlargesAndKeepsOnlyCleanRounds) {
  Fixture fixture;
  fixture.options.min_rounds = 2;
  fixture.options.imitation_finetune_rounds = 2;
  fixture.options.enlarge_rounds = 3;
  fixture.options.loss.weight[LossTerm::rollout_safety] = 100.0;
  Trainer trainer(fixture.problem, fixture.demonstrations, fixture.networks, fixture.options, 5);
  // None is safe, then all are, so that B grows where it may.
  trainer.set_rollout_labels([round = 0](const Dynamics&, const Points& x) mutable {
    return std::vector<bool>(x.rows(), ++round >= 5);
  });
  trainer.add_source(std::make_shared<ScriptedSource>(std::set<std::int64_t>{1, 3, 5}));
  std::vector<Networks> after;
  std::vector<Stage> stages;
  trainer.on_round([&](const RoundSummary& row, const Trainer& t) {
    after.push_back(t.networks());
    stages.push_back(row.stage);
    return true;
  });
  const TrainerSummary summary = trainer.run();
  EXPECT_TRUE(summary.clean);
  EXPECT_EQ(stages,
            (std::vector<Stage>{Stage::search, Stage::search, Stage::search, Stage::imitation_finetune,
                                Stage::imitation_finetune, Stage::enlarge, Stage::enlarge, Stage::enlarge}));
  const auto hash = [](const NetworkWeights& stack) { return weight_hash({stack, stack, stack}); };
  EXPECT_EQ(weight_hash(after[3]), weight_hash(after[2])) << "round 3 was not clean";
  for (NetworkWeights Networks::*network : {&Networks::f, &Networks::V, &Networks::B})
    EXPECT_NE(hash(after[4].*network), hash(after[3].*network));
  for (std::size_t round : {5, 6, 7}) {
    EXPECT_EQ(hash(after[round].f), hash(after[4].f));
    EXPECT_EQ(hash(after[round].V), hash(after[4].V));
  }
  EXPECT_EQ(hash(after[5].B), hash(after[4].B)) << "round 5 was not clean";
  EXPECT_NE(hash(after[6].B), hash(after[5].B));
  EXPECT_NE(hash(after[7].B), hash(after[6].B));
}

// Rollouts that are never safe ask B to shrink: what is certified already stays.
TEST(Trainer, NoRoundThatEnlargesLosesMoreThanAHundredthOfTheSafeSet) {
  Fixture fixture;
  fixture.options.imitation_finetune_rounds = 0;
  fixture.options.enlarge_rounds = 4;
  Trainer trainer(fixture.problem, fixture.demonstrations, fixture.networks, fixture.options, 5);
  trainer.set_rollout_labels(
      [](const Dynamics&, const Points& x) { return std::vector<bool>(x.rows(), false); });
  trainer.add_source(std::make_shared<ScriptedSource>(std::set<std::int64_t>{}));
  RandomStream random(3, "test");
  const Points points = uniform_points(fixture.problem.workspace, 20000, random);
  std::vector<double> share;
  std::vector<RoundSummary> rows;
  trainer.on_round([&](const RoundSummary& row, const Trainer& t) {
    const Points value = Evaluator(t.networks().B).value(points);
    share.push_back(static_cast<double>((value.array() <= 0.0).count()) / 20000.0);
    rows.push_back(row);
    return true;
  });
  trainer.run();
  ASSERT_EQ(rows.back().stage, Stage::enlarge);
  for (std::size_t k = 1; k < rows.size(); ++k) {
    if (rows[k].stage != Stage::enlarge) continue;
    EXPECT_GE(share[k], 0.985 * share[k - 1]);
    EXPECT_NEAR(rows[k].volume, share[k], 0.02);
  }
}

TEST(Trainer, StartsAnewFromTheWarmStart) {
  Fixture fixture;
  fixture.options.rate_period = 2;
  fixture.options.max_level_shift = 0.0;
  fixture.options.rate_f = fixture.options.rate_certificates = 1e-9;  // nothing else changes a weight
  fixture.options.weight_decay = 0.0;
  std::vector<Networks> rounds;
  Trainer trainer = fixture.trainer(5);
  trainer.on_round([&](const RoundSummary&, const Trainer& t) {
    rounds.push_back(t.networks());
    return true;
  });
  trainer.run();
  const auto moved = [&](std::size_t round, NetworkWeights Networks::*network) {
    return ((rounds[round].*network).layers[0].weight - (rounds[round - 1].*network).layers[0].weight).norm();
  };
  ASSERT_EQ(rounds.size(), 5U);  // warm start and four rounds
  for (NetworkWeights Networks::*drawn : {&Networks::B, &Networks::V}) {
    for (std::size_t round : {1, 2, 4}) EXPECT_LT(moved(round, drawn), 1e-4) << round;
    EXPECT_GT(moved(3, drawn), 0.5);
  }
  for (std::size_t round : {1, 2, 3, 4}) EXPECT_LT(moved(round, &Networks::f), 1e-4) << round;
}

TEST(Trainer, TrainsWithThePlansWeights) {
  Fixture fixture;
  fixture.options.rate_period = 2;
  Trainer trainer = fixture.trainer(5);
  trainer.run();
  const std::vector<RoundSummary> history = trainer.state().history;
  ASSERT_EQ(history.size(), 5U);  // warm start and four rounds
  for (std::size_t round : {1, 2, 3, 4}) {
    const RoundSummary& row = history[round];
    const double weight = (round < 3 ? 1.0 : 0.5) * fixture.options.loss.weight[LossTerm::imitation];
    EXPECT_NEAR(row.loss_terms[LossTerm::imitation], weight * row.mse, 1e-6 * row.loss) << round;
    EXPECT_NEAR(row.loss, std::accumulate(row.loss_terms.begin(), row.loss_terms.end(), 0.0),
                1e-4 * row.loss);
  }
}

TEST(Trainer, StopsWhenTheCallbackSaysSo) {
  Fixture fixture;
  Trainer trainer = fixture.trainer(1);
  trainer.on_round([](const RoundSummary& row, const Trainer&) { return row.round < 2; });
  const TrainerSummary summary = trainer.run();
  EXPECT_TRUE(summary.stopped);
  EXPECT_EQ(summary.rounds, 2);
}

TEST(Trainer, WarmStartIsTheSameUnderBothEngines) {
  Fixture fixture;
  fixture.options.warm_start.steps = 30;
  fixture.options.rounds = fixture.options.min_rounds = 1;
  double mse[2];
  int at = 0;
  for (const char* engine : {"fused", "autograd"}) {
    fixture.options.engine = engine;
    Trainer trainer = fixture.trainer(1);
    trainer.run();
    mse[at++] = trainer.state().history.front().mse;
  }
  EXPECT_NEAR(mse[0], mse[1], 1e-4 * mse[1]);
}

TEST(Trainer, RefusesNetworksOfAnotherShape) {
  Fixture fixture;
  Trainer trainer = fixture.trainer(1);
  TrainerState state = trainer.state();
  state.networks.B.layers[0].weight.resize(3, 2);
  EXPECT_THROW(trainer.restore(state), Error);
}

TEST(BatchSampler, DrawsPointsForBAlongTheDemonstrationsUnlessOneMeetsTheObstacle) {
  Fixture fixture;
  const std::int64_t in_X0 = fixture.options.batch.initial, on_path = fixture.options.batch.path = 500;
  RandomStream random(1, "test");
  const auto drawn = [&](const SafetyProblem& problem) {
    return BatchSampler(problem, fixture.demonstrations, fixture.options).draw(random).initial;
  };
  const Points points = drawn(fixture.problem), shown = stack_positions(fixture.demonstrations);
  ASSERT_EQ(points.rows(), in_X0 + on_path);
  EXPECT_LE(fixture.problem.initial->level(points.topRows(in_X0)).maxCoeff(), 0.0);
  const Points path = points.bottomRows(on_path);
  for (Eigen::Index i = 0; i < path.rows(); ++i)
    ASSERT_EQ((shown.rowwise() - path.row(i)).rowwise().norm().minCoeff(), 0.0);
  EXPECT_GT((fixture.problem.initial->level(path).array() > 0.0).count(), 400);

  ProblemOptions p;
  p.frame = "normalised";
  p.unsafe.type = "ball";
  p.unsafe.center = {shown(400, 0), shown(400, 1)};
  p.unsafe.radius = 0.01;
  EXPECT_EQ(drawn(make_problem(p, fixture.demonstrations, fixture.frame)).rows(), in_X0);
  fixture.options.batch.path = 0;
  EXPECT_EQ(drawn(fixture.problem).rows(), in_X0);
}

TEST(BatchSampler, DrawsAlongTheDemonstrationsWhereThereIsAPhase) {
  Fixture fixture;
  RandomStream random(1, "test");
  const auto drawn = [&](const std::vector<Demonstration>& shown) {
    return BatchSampler(fixture.problem, shown, fixture.options).draw(random).initial;
  };
  DemonstrationSet set = handwriting("Sine");
  fixture.frame = find_state(set, "phase", "max_abs", {"each"});
  fixture.demonstrations = fixture.frame.normalize(set.demonstrations);
  ProblemOptions p;
  p.frame = "normalised";
  fixture.problem = make_problem(p, fixture.demonstrations, fixture.frame);
  const Points more = drawn(fixture.demonstrations);
  ASSERT_EQ(more.rows(), fixture.options.batch.initial + fixture.options.batch.path);
  // B is asked for from the start to the goal.
  EXPECT_LT(more.col(2).minCoeff(), 0.2 * fixture.problem.phase_start);
  EXPECT_GT((fixture.problem.initial->level(more).array() > 0.0).count(), fixture.options.batch.initial / 2);
}

TEST(BatchSampler, LeavesOutSamplesNearTheObstacleAndOnlyThose) {
  Fixture fixture;
  ProblemOptions p;
  p.frame = "normalised";
  p.unsafe.type = "ball";
  const Vector through = fixture.demonstrations[0].position.row(400);
  p.unsafe.center = {through[0], through[1]};
  p.unsafe.radius = 0.05;
  const SafetyProblem problem = make_problem(p, fixture.demonstrations, fixture.frame);
  fixture.options.obstacle_margin = 0.05;
  const BatchSampler sampler(problem, fixture.demonstrations, fixture.options);
  EXPECT_GT(sampler.left_out_samples(), 0);
  const Points& kept = sampler.position();
  for (Eigen::Index i = 0; i < kept.rows(); ++i) ASSERT_GT((kept.row(i).transpose() - through).norm(), 0.09);
  const Points all = stack_positions(fixture.demonstrations);
  Eigen::Index far = 0;
  for (Eigen::Index i = 0; i < all.rows(); ++i)
    far += (all.row(i).transpose() - through).norm() >
           0.05 + 0.15;  // twice obstacle_margin per axis, to a corner
  EXPECT_GE(kept.rows(), far);
}

TEST(BatchSampler, KeepsSamplesDeepInsideTheObstacle) {
  Fixture fixture;
  ProblemOptions p;
  p.frame = "normalised";
  p.unsafe.type = "box";
  const Vector through = fixture.demonstrations[0].position.row(400);
  p.unsafe.lower = {through[0] - 0.1, through[1] - 0.1};
  p.unsafe.upper = {through[0] + 0.1, through[1] + 0.1};
  const SafetyProblem problem = make_problem(p, fixture.demonstrations, fixture.frame);
  fixture.options.obstacle_margin = 0.04;
  const BatchSampler sampler(problem, fixture.demonstrations, fixture.options);
  const auto distance = [&](const Points& x) {  // per axis, from the obstacle's centre
    return Vector((x.rowwise() - through.transpose()).cwiseAbs().rowwise().maxCoeff());
  };
  const Vector kept = distance(sampler.position()), all = distance(stack_positions(fixture.demonstrations));
  EXPECT_GT((kept.array() < 0.06).count(), 0);
  EXPECT_EQ((kept.array() < 0.06 - 1e-9).count(), (all.array() < 0.06 - 1e-9).count());
  EXPECT_EQ((kept.array() > 0.06 + 1e-9 && kept.array() < 0.14 - 1e-9).count(), 0);
}

TEST(BatchSampler, DrawsEverySetFromItself) {
  Fixture fixture;
  const BatchSampler sampler(fixture.problem, fixture.demonstrations, fixture.options);
  RandomStream random(1, "batch test");
  const Batch batch = sampler.draw(random);
  EXPECT_EQ(batch.workspace.rows(), fixture.options.batch.workspace);
  EXPECT_LE(batch.workspace.cwiseAbs().maxCoeff(), 1.25);
  EXPECT_LE(fixture.problem.initial->level(batch.initial.topRows(fixture.options.batch.initial)).maxCoeff(),
            0.0);
  const Vector in_ball = fixture.problem.unsafe->level(batch.unsafe),
               in_workspace_margin = fixture.problem.workspace_margin->level(batch.unsafe);
  EXPECT_LE(in_ball.cwiseMin(in_workspace_margin).maxCoeff(), 0.0);
  EXPECT_EQ(batch.boundary.rows(), boundary_points_drawn);
  EXPECT_LT(fixture.problem.unsafe->level(batch.boundary).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(BatchSampler, DrawsBacktrackedPointsBesideDemonstrationsAndLabels) {
  Fixture fixture;
  fixture.options.obstacle_margin = 0.0;
  const Eigen::Index demonstrations = fixture.options.batch.demonstrations;
  BatchSampler sampler(fixture.problem, fixture.demonstrations, fixture.options);
  sampler.set_labels(Points::Constant(3, 2, 0.1), Points::Constant(3, 2, 0.2));
  sampler.set_backtracked(
      {Points::Constant(5, 2, 0.3), Points::Constant(7, 2, 0.4), Points::Constant(7, 2, -0.5)});
  RandomStream random(1, "batch test");
  const Batch with = sampler.draw(random);
  ASSERT_EQ(with.unsafe_rollouts.rows(), labelled_points / 2 + upstream_points);
  EXPECT_EQ((with.unsafe_rollouts.topRows(labelled_points / 2).array() == 0.2).count(), labelled_points);
  EXPECT_EQ((with.unsafe_rollouts.bottomRows(upstream_points).array() == 0.3).count(), 2 * upstream_points);
  ASSERT_EQ(with.position.rows(), demonstrations + correction_points);
  ASSERT_EQ(with.velocity.rows(), with.position.rows());
  EXPECT_EQ((with.position.bottomRows(correction_points).array() == 0.4).count(), 2 * correction_points);
  EXPECT_EQ((with.velocity.bottomRows(correction_points).array() == -0.5).count(), 2 * correction_points);
  EXPECT_EQ(with.safe.rows(), labelled_points / 2);

  const Points none(0, 2);
  sampler.set_backtracked({none, none, none});
  const Batch without = sampler.draw(random);
  EXPECT_EQ(without.unsafe_rollouts.rows(), labelled_points / 2);
  EXPECT_EQ(without.position.rows(), demonstrations);
}

// A draw's velocity says which sample it is. Of 400 displacements of .02 the mean square is .0004 with a
// standard deviation of .00003.
TEST(BatchSampler, DisplacesSamplesInX0AcrossTheirVelocityAndNoOthers) {
  Fixture fixture;
  fixture.options.batch.start_jitter = 0.02;
  fixture.options.batch.demonstrations = 20000;
  double number = 1.0;
  for (Demonstration& each : fixture.demonstrations)
    for (Eigen::Index i = 0; i < each.samples(); ++i) each.velocity(i, 0) = number++;
  fixture.options.obstacle_margin = 0.0;
  const BatchSampler sampler(fixture.problem, fixture.demonstrations, fixture.options);
  RandomStream random(1, "batch test");
  const Batch batch = sampler.draw(random);
  double squares = 0.0;
  int displaced = 0;
  for (Eigen::Index k = 0; k < batch.position.rows(); ++k) {
    const Vector x = sampler.position().row(static_cast<Eigen::Index>(batch.velocity(k, 0)) - 1);
    const Vector moved = batch.position.row(k).transpose() - x;
    if (fixture.problem.initial->level(Points(x.transpose()))[0] > 0.0) {
      ASSERT_EQ(moved.norm(), 0.0);
    } else {
      squares += moved.squaredNorm();
      ASSERT_LT(std::abs(moved.dot(batch.velocity.row(k))), 1e-9 * batch.velocity.row(k).norm());
      ++displaced;
    }
  }
  ASSERT_GT(displaced, 400);
  EXPECT_NEAR(squares / displaced, 0.0004, 0.0001);
}

// B = x - 0.5 on a ball at (0.7, 0): violated only where x < 0.5 inside the ball, a sliver of its area.
TEST(Falsifiers, FindASliverThatViolates) {
  ProblemOptions p;
  p.frame = "normalised";
  p.containment = 0.0;
  p.unsafe.type = "ball";
  p.unsafe.center = {0.7, 0.0};
  p.unsafe.radius = 0.201;
  p.initial.type = "ball";
  p.initial.center = {-0.5, 0.0};
  p.initial.radius = 0.1;
  Fixture fixture;
  const SafetyProblem problem = make_problem(p, fixture.demonstrations, fixture.frame);
  Networks networks;
  Layer linear{Points(1, 2), Vector::Constant(1, -0.5)};
  linear.weight << 1.0, 0.0;
  networks.B.layers = {linear};
  networks.V.layers = {{Points::Identity(2, 2), Vector::Zero(2)}};
  networks.V.head = Head::squared_norm;
  networks.V.quadratic = 0.1;
  networks.f.layers = {{-Points::Identity(2, 2), Vector::Zero(2)}};
  LocalSearchFalsifier search(problem, {20000, 100});
  const Counterexamples found = search.find(networks, problem, 0.01, 1, 1);
  const auto unsafe = static_cast<std::size_t>(Condition::unsafe);
  ASSERT_GT(found.counts[unsafe], 0);
  for (Eigen::Index i = 0; i < found.points[unsafe].rows(); ++i) EXPECT_LE(found.points[unsafe](i, 0), 0.5);
  EXPECT_EQ(found.counts[static_cast<std::size_t>(Condition::lyapunov_decrease)], 0);
  EXPECT_EQ(found.counts[static_cast<std::size_t>(Condition::initial)], 0);
}

}  // namespace
}  // namespace s2nnds
