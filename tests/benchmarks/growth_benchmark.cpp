// SPDX-License-Identifier: BSD-3-Clause
// How a training step, scoring, a proof and one evaluation of f grow with width, dimension and samples.
// compare.sh --growth prints the table; or run it by hand: growth_benchmark --benchmark_filter=step
#include <benchmark/benchmark.h>
#include <torch/script.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "evaluated_policies.h"
#include "s2nnds/networks/evaluator.h"
#include "s2nnds/runs/execution_options.h"
#include "s2nnds/runs/prepared_run.h"
#include "s2nnds/runs/run_record.h"
#include "s2nnds/runs/threads.h"
#include "s2nnds/verification/executed_motion.h"
#include "s2nnds/verification/prover.h"
#include "work.h"

namespace {

using namespace s2nnds;
using namespace s2nnds::benchmarks;

// Arguments: dimension, width of all three networks, samples.
WorkSize size_of(const benchmark::State& state) {
  return {state.range(0), state.range(1), state.range(1), state.range(2)};
}

template <typename Work>
void run(benchmark::State& state, Work& work) {
  for (auto _ : state) work.run();
  state.counters["gflops"] =
      benchmark::Counter(1e-9 * work.flops(), benchmark::Counter::kIsIterationInvariantRate);
}

void step(benchmark::State& state) {
  TrainingStep work(size_of(state));
  run(state, work);
}
void score(benchmark::State& state) {
  Scoring work(size_of(state), state.range(2));
  run(state, work);
}

void sizes(benchmark::internal::Benchmark* each, std::int64_t samples) {
  each->ArgNames({"dimension", "width", "samples"})->Unit(benchmark::kMillisecond)->UseRealTime();
  for (const std::int64_t width : {32, 64, 128, 256}) each->Args({2, width, samples});
  for (const std::int64_t dimension : {3, 4, 5, 6}) each->Args({dimension, 64, samples});
  for (const std::int64_t factor : {2, 4, 8}) each->Args({2, 64, factor * samples});
}
BENCHMARK(step)->Apply([](auto* each) { sizes(each, 512); });
BENCHMARK(score)->Apply([](auto* each) { sizes(each, 25000); });

// f(x)_i = -(1 / width) sum_j g_j tanh(g_j x_i), neuron j of coordinate i: falls towards the goal along every
// axis.
NetworkWeights descent(std::int64_t n, std::int64_t width) {
  RandomStream random(0, "descent");
  Layer in, out;
  in.weight = Points::Zero(width, n);
  for (std::int64_t j = 0; j < width; ++j) in.weight(j, j % n) = random.uniform(0.3, 1.0);
  in.activation = Activation::tanh;
  out.weight = -in.weight.transpose() * (static_cast<double>(n) / static_cast<double>(width));
  return {{in, out}, Head::zero_at_origin, 0.0};
}

// Networks that meet every condition of the sets below: V = 1.05 |x|^2, and B = sum_i softplus(20 (+-x_i -
// 0.9)) - 0.3, which is convex with its least value at the goal.
Networks provable(std::int64_t n, std::int64_t width) {
  Networks networks;
  networks.f = descent(n, width);
  networks.V = {{Layer{Points::Identity(n, n), {}, Activation::identity}}, Head::squared_norm, 0.05};
  Layer in, out;
  in.weight = Points::Zero(2 * n, n);
  in.weight.topRows(n).diagonal().setConstant(20.0);
  in.weight.bottomRows(n).diagonal().setConstant(-20.0);
  in.bias = Vector::Constant(2 * n, -18.0);
  in.activation = Activation::softplus;
  out.weight = Points::Ones(1, 2 * n);
  out.bias = Vector::Constant(1, -0.3);
  networks.B = {{in, out}, Head::plain, 0.0};
  return networks;
}

SafetyProblem provable_sets(std::int64_t n) {
  SafetyProblem problem = make_sets(n);
  const Vector one = Vector::Ones(n);
  problem.workspace = Box{-1.25 * one, 1.25 * one};
  problem.initial = box_region(Box{-0.5 * one, -0.3 * one});
  Vector center = Vector::Zero(n);
  center[n - 1] = 1.1;
  problem.unsafe = ball(center, 0.1);
  problem.workspace_margin = nullptr;
  return problem;
}

void report(benchmark::State& state, const ProofResult& result) {
  state.SetLabel(std::string(to_string(result.guarantee)));
  state.counters["boxes"] = static_cast<double>(result.boxes);
  state.counters["boxes_per_s"] = static_cast<double>(result.boxes) / result.seconds;
}

void proof(benchmark::State& state) {
  const Networks networks = provable(state.range(0), state.range(1));
  const SafetyProblem problem = provable_sets(state.range(0));
  ProofOptions options;
  options.max_boxes = 2000000;
  options.max_seconds = 60.0;
  ProofResult result;
  for (auto _ : state) result = prove(networks, problem, 0.01, options);
  report(state, result);
}
BENCHMARK(proof)
    ->ArgNames({"dimension", "width"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->ArgsProduct({{2}, {32, 64, 128, 256}})
    ->ArgsProduct({{3, 4, 5, 6}, {64}});

// The proof of the run file that $S2NNDS_RUN names.
void proof_of_run(benchmark::State& state) {
  const char* path = std::getenv("S2NNDS_RUN");
  if (path == nullptr) return state.SkipWithError("set S2NNDS_RUN to a run file");
  const RunRecord record = load_run(path);
  const PreparedRun setup = prepare(record);
  ProofResult result;
  for (auto _ : state) {
    result =
        prove(record.networks, setup.problem, record.certificate.level_band, setup.config.verification.proof);
  }
  report(state, result);
}
BENCHMARK(proof_of_run)->Unit(benchmark::kMillisecond)->UseRealTime();

// And that of its motion as executed: invariance and the ball in which it arrives.
void executed_proof_of_run(benchmark::State& state) {
  const char* path = std::getenv("S2NNDS_RUN");
  if (path == nullptr) return state.SkipWithError("set S2NNDS_RUN to a run file");
  const RunRecord record = load_run(path);
  const PreparedRun setup = prepare(record);
  const ProofFunctions functions = ProofFunctions::of(record.networks);
  const ExecutionModel model =
      execution_model(setup.config.execution, setup.data.frame, record.certificate.float32_error);
  ExecutedMotion motion;
  for (auto _ : state) motion = prove_executed(functions, setup.problem, model);
  state.SetLabel(motion.invariant ? "invariant as executed" : "open");
  state.counters["boxes"] = static_cast<double>(motion.boxes);
}
BENCHMARK(executed_proof_of_run)->Unit(benchmark::kMillisecond)->UseRealTime();

// One point at a time, as a control loop asks.
template <typename Velocity>
void evaluate(benchmark::State& state, const Velocity& velocity) {
  double x[2] = {0.1, 0.3};
  for (int i = 0; i < 100; ++i)
    benchmark::DoNotOptimize(velocity(x));  // TorchScript optimises itself meanwhile
  for (auto _ : state) {
    x[0] = x[0] > 1.0 ? -1.0 : x[0] + 1e-5;
    benchmark::DoNotOptimize(velocity(x));
  }
}
void header(benchmark::State& state, Velocity velocity) {
  evaluate(state, [&](const double* x) {
    double v[2];
    velocity(x, v);
    return v[0];
  });
}
void header_float(benchmark::State& state) { header(state, float_policy(static_cast<int>(state.range(0)))); }
void header_double(benchmark::State& state) {
  header(state, double_policy(static_cast<int>(state.range(0))));
}
BENCHMARK(header_float)->ArgName("width")->Arg(32)->Arg(64)->Arg(128)->Arg(256);
BENCHMARK(header_double)->ArgName("width")->Arg(32)->Arg(64)->Arg(128)->Arg(256);

void evaluator(benchmark::State& state) {
  NetworkOptions options;
  options.f.network.hidden.assign(3, state.range(0));
  RandomStream random(0, "evaluation");
  const Evaluator f(VectorField(2, options.f, random)->snapshot());
  Points point(1, 2);
  evaluate(state, [&](const double* x) {
    point << x[0], x[1];
    return f.value(point)(0, 0);
  });
}
BENCHMARK(evaluator)->ArgName("width")->Arg(32)->Arg(64)->Arg(128)->Arg(256);

void torchscript(benchmark::State& state) {
  torch::jit::Module policy =
      torch::jit::load(S2NNDS_POLICY_FOLDER "/width_" + std::to_string(state.range(0)) + ".pt");
  policy.eval();
  torch::InferenceMode inference;
  evaluate(state, [&](const double* x) {
    const torch::Tensor point = torch::tensor({{static_cast<float>(x[0]), static_cast<float>(x[1])}});
    return policy.forward({point}).toTensor().data_ptr<float>()[0];
  });
}
BENCHMARK(torchscript)->ArgName("width")->Arg(32)->Arg(64)->Arg(128)->Arg(256);

}  // namespace

int main(int argc, char** argv) {
  const char* threads = std::getenv("S2NNDS_THREADS");
  set_threads(threads ? std::atoi(threads) : 0);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
