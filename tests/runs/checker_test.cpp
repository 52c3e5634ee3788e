// SPDX-License-Identifier: BSD-3-Clause
// The prover and s2nnds-check, which share nothing, on the same runs.
#ifdef S2NNDS_CHECK

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "s2nnds/core/random.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/training_run.h"
#include "s2nnds/runs/verification_run.h"
#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

// What a run was certified of: a configuration whose sets are in the data's frame, and networks.
struct Certified {
  std::string config;
  Networks networks;
  Frame frame;
};

constexpr const char* kMotion = "name = \"checked\"\n[data]\nsource = \"handwriting\"\nmotion = \"Sine\"\n";

Frame frame_of(const std::string& config) { return prepare(parse_config(config, "a test"), "").data.frame; }

std::string point_text(const Frame& frame, double x, double y) {
  const Vector point = frame.to_data((Vector(2) << x, y).finished());
  return fmt::format("[{}, {}]", point(0), point(1));
}

Certified hand_made() {
  const Frame frame = frame_of(kMotion);
  const std::string config = fmt::format(
      "{}[problem]\n"
      "initial = {{ type = \"ball\", center = {}, radius = {} }}\n"
      "unsafe = {{ type = \"ball\", center = {}, radius = {} }}\n"
      "[training]\nlevel_band = 0.01\n",
      kMotion, point_text(frame, 0.3, -0.2), 0.2 * frame.position_scale, point_text(frame, 1.05, 1.05),
      0.1 * frame.position_scale);
  Networks networks = simple_networks();
  networks.B.layers.back().bias = Vector::Zero(1);
  return {config, networks, frame};
}

RunRecord run_of(const std::string& config, const Networks& networks, ProofCovers* covers = nullptr,
                 const std::vector<std::string>& settings = {}) {
  const PreparedRun setup = prepare(parse_config(config, "a test", settings), "");
  RunRecord record = new_record(setup, config);
  record.networks = networks;
  VerificationOptions options = setup.config.verification;
  options.proof.max_boxes = 100000;
  verify(setup, record, Method::proof, options, nullptr, covers);
  return record;
}
RunRecord run_of(const Certified& certified, ProofCovers* covers = nullptr) {
  return run_of(certified.config, certified.networks, covers);
}

Certified trained() {
  const Frame frame = frame_of(kMotion);
  const std::string config = fmt::format(
      "{}test = [5, 6]\n[problem]\ninitial = {{ type = \"ball\", center = {}, radius = {} }}\n"
      "unsafe = {{ type = \"ball\", center = {}, radius = {} }}\n",
      kMotion, point_text(frame, -1.0, 0.0), 0.1 * frame.position_scale, point_text(frame, -0.32, 0.22),
      0.12 * frame.position_scale);
  const PreparedRun setup = prepare(parse_config(config, "a test"), "");
  RunRecord record = new_record(setup, config);
  TrainingHooks hooks;
  hooks.until_certified = true;
  train(setup, record, hooks);
  return {config, record.networks, frame};
}

// The certificate of other weights, as if they had been proved.
void claim(RunRecord& record, const Networks& networks) {
  record.networks = networks;
  seal_certificate(prepare(record), record);
}

class Checker : public testing::Test {
 protected:
  Checker() : folder_(std::filesystem::temp_directory_path() / fmt::format("s2nnds-check-{}", ::getpid())) {
    std::filesystem::create_directory(folder_);
  }
  ~Checker() override { std::filesystem::remove_all(folder_); }

  int exit_code(const RunRecord& record) const {
    const std::string path = (folder_ / "run.h5").string();
    save_run(path, record);
    return exit_code(path);
  }
  int exit_code(const std::string& path) const {
    const int status = std::system(fmt::format("'{}' '{}' >/dev/null 2>&1", S2NNDS_CHECK, path).c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  // Small falsifications of a certified run: what the prover accepts, the checker shows as well.
  void mutate(const Certified& certified, const char* name, int count, std::uint64_t seed) const {
    ASSERT_EQ(run_of(certified).certificate.guarantee, Guarantee::invariant);
    int accepted = 0, rejected = 0, neither = 0;
    RandomStream random(seed, "mutations");
    for (int k = 0; k < count; ++k) {
      Networks networks = certified.networks;
      std::vector<std::string> settings;
      const double size = std::pow(10.0, random.uniform(-2.0, 1.0)), change = random.uniform(-size, size);
      const auto moved = [&](const auto& point, double by) {
        const double angle = random.uniform(0.0, 6.3), step = by * certified.frame.position_scale;
        return fmt::format("[{}, {}]", point[0] + step * std::cos(angle), point[1] + step * std::sin(angle));
      };
      const std::size_t kind = random.below(8);
      const Config config = parse_config(certified.config, "a test");
      if (kind == 0) {
        settings.push_back(
            fmt::format("problem.initial.radius={}", config.problem.initial.radius * std::exp(change)));
      } else if (kind == 1) {
        settings.push_back("problem.unsafe.center=" + moved(config.problem.unsafe.center, 0.5 * change));
      } else if (kind == 2) {
        settings.push_back(
            fmt::format("problem.unsafe.radius={}", config.problem.unsafe.radius * std::exp(change)));
      } else if (kind == 3) {
        settings.push_back(fmt::format("training.level_band={}", 0.01 * (1.0 + 20.0 * std::abs(change))));
      } else if (kind == 4) {
        settings.push_back("data.goal=" + moved(certified.frame.goal, 0.3 * change));
      } else if (kind == 5) {
        networks.B.layers.back().bias(0) += change;  // the level
      } else {
        NetworkWeights* changed[] = {&networks.f, &networks.V, &networks.B};
        std::vector<Layer>& layers = changed[random.below(3)]->layers;
        Points& weight = layers[random.below(layers.size())].weight;
        weight.data()[random.below(static_cast<std::size_t>(weight.size()))] += change;
      }
      RunRecord record;
      try {
        record = run_of(certified.config, networks, nullptr, settings);
      } catch (const Error&) {
        ++rejected;  // the scene is impossible
        continue;
      }
      const bool invariant = record.certificate.guarantee == Guarantee::invariant;
      const bool shown = invariant && exit_code(record) == 0;
      (!invariant ? rejected : shown ? accepted : neither) += 1;
      EXPECT_EQ(shown, invariant) << "mutation " << k << " of kind " << kind << " by " << change;
    }
    fmt::print(
        "{} mutations of seed {} of the {} run: {} still true by the checker, {} rejected by the prover, {} "
        "neither\n",
        count, seed, name, accepted, rejected, neither);
    EXPECT_GT(accepted, count / 50);
    EXPECT_GT(rejected, count / 50);
  }

  std::filesystem::path folder_;
};

TEST_F(Checker, ShowsWhatTheProverProved) {
  const RunRecord record = run_of(hand_made());
  ASSERT_EQ(record.certificate.guarantee, Guarantee::invariant);
  EXPECT_EQ(exit_code(record), 0);
}

TEST_F(Checker, DoesNotShowWhatIsFalse) {
  RunRecord record = run_of(hand_made());
  Networks other = simple_networks();
  other.B.layers.back().weight *= -1.0;
  record.networks = other;
  EXPECT_EQ(exit_code(record), 2);  // not the weights that its text names
  claim(record, other);
  EXPECT_EQ(exit_code(record), 3);
  other = simple_networks();
  other.f.layers.front().weight *= -1.0;
  claim(record, other);
  EXPECT_EQ(exit_code(record), 3);
}

TEST_F(Checker, ReadsAProofAndRefusesOneWithAHole) {
  ProofCovers covers;
  const RunRecord record = run_of(hand_made(), &covers);
  ASSERT_EQ(covers.size(), 5u);
  const std::string path = (folder_ / "proof.h5").string();
  save_proof(path, record, covers);
  EXPECT_EQ(exit_code(path), 0);
  for (auto& [name, bytes] : covers) {
    ASSERT_FALSE(bytes.empty()) << name;
    const std::vector<std::uint8_t> whole = bytes;
    bytes.pop_back();
    if (bytes.empty()) bytes.push_back(0xff);  // bisections without an end
    save_proof(path, record, covers);
    EXPECT_EQ(exit_code(path), 2) << name;
    bytes = whole;
    bytes.push_back(0);
    save_proof(path, record, covers);
    EXPECT_EQ(exit_code(path), 2) << name;
    bytes = whole;
  }
  save_proof(path, record, covers);
  std::string file;
  {
    std::ifstream stream(path, std::ios::binary);
    file.assign(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  const auto code_of = [&](const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    return exit_code(path);
  };
  EXPECT_EQ(code_of(file), 0);
  RandomStream random(3, "damage");
  for (int k = 0; k < 40; ++k) {
    std::string damaged = file;
    damaged[random.below(damaged.size())] ^= static_cast<char>(1 << random.below(8));
    EXPECT_EQ(code_of(damaged), 2) << k;
    EXPECT_EQ(code_of(file.substr(0, random.below(file.size()))), 2) << k;
  }
}

TEST_F(Checker, RefusesWhatItCannotReadWithOneCode) {
  EXPECT_EQ(exit_code(std::string("/no/such/run.h5")), 2);
  RunRecord record = run_of(hand_made());
  Networks other = simple_networks();
  other.B.layers.front().activation = Activation::elu;
  claim(record, other);
  EXPECT_EQ(exit_code(record), 2);
  record = run_of(hand_made());
  other = simple_networks();
  other.V.head = Head::diffeomorphism;
  other.V.quadratic = 0.0;
  claim(record, other);
  EXPECT_EQ(exit_code(record), 2);
}

TEST_F(Checker, ReadsExpressions) {
  const auto config = [](const std::string& level) {
    return fmt::format(
        "{}[problem]\nframe = \"normalised\"\n"
        "initial = {{ type = \"ball\", center = [0.3, -0.2], radius = 0.2 }}\n"
        "unsafe = {{ type = \"expression\", level = \"{}\" }}\n[training]\nlevel_band = 0.01\n",
        kMotion, level);
  };
  for (const char* level :
       {"(((x - 1.05)/0.3)**2)**(1/3) + (((y - 1.05)/0.3)^2)**(1/3) - 0.5", "max(1.0 - x, 1 -y, x + y - 2.2)",
        "min(0.9*2 - x*0.9 - y*0.9, 1)", "-(0.05 - (x - 1.05)**2) + (y - 1.05)**2"}) {
    const RunRecord record = run_of(config(level), simple_networks());
    ASSERT_EQ(record.certificate.guarantee, Guarantee::invariant) << level;
    EXPECT_EQ(exit_code(record), 0) << level;
  }
  for (const char* level : {"x*x + (y - 0.7)**2 - 0.01", "min(x*x + (y - 0.7)**2 - 0.01, 1)"}) {
    RunRecord record = run_of(config(level), simple_networks());
    ASSERT_NE(record.certificate.guarantee, Guarantee::invariant) << level;
    claim(record, simple_networks());
    EXPECT_EQ(exit_code(record), 3) << level;
  }
  RunRecord record = run_of(config("(1.05 - x)**3"), simple_networks());
  claim(record, simple_networks());
  EXPECT_EQ(exit_code(record), 2);
}

// The hand-made system with a phase s beside x that begins at `start`, as a barrier that is negative for |x_i| < 0.8 and
// |s / start - 0.5| < 0.65.
Networks networks_with_phase(double start) {
  Networks networks = {linear_field(-Points::Identity(3, 3)), {}, {}};
  networks.V.layers = {layer(Points::Identity(3, 3), Vector(), Activation::identity)};
  networks.V.head = Head::squared_norm;
  networks.V.quadratic = 0.05;
  Points inner = Points::Zero(6, 3), outer(1, 6);
  Vector shift(6);
  for (int i = 0; i < 3; ++i) {
    const double gain = i == 2 ? 8.0 / start : barrier_gain, middle = i == 2 ? 0.5 * start : 0.0,
                 edge = i == 2 ? 0.65 * start : barrier_edge;
    inner(2 * i, i) = inner(2 * i + 1, i) = gain;
    shift(2 * i) = -gain * (middle + edge);
    shift(2 * i + 1) = gain * (edge - middle);
    outer(0, 2 * i) = 1.0;
    outer(0, 2 * i + 1) = -1.0;
  }
  networks.B.layers = {layer(inner, shift, Activation::tanh),
                       layer(outer, Vector::Constant(1, 6.0 - barrier_level), Activation::tanh),
                       layer(Points::Identity(1, 1), Vector(), Activation::identity)};
  return networks;
}

TEST_F(Checker, ReadsStatesWithAPhase) {
  const auto config = [](const std::string& center) {
    return fmt::format(
        "{}state = \"phase\"\n[problem]\nframe = \"normalised\"\n"
        "initial = {{ type = \"ball\", center = [0.3, -0.2], radius = 0.2 }}\n"
        "unsafe = {{ type = \"ball\", center = {}, radius = 0.1 }}\n[training]\nlevel_band = 0.01\n",
        kMotion, center);
  };
  const Networks networks =
      networks_with_phase(prepare(parse_config(config("[1.05, 1.05]"), "a test"), "").problem.phase_start);
  RunRecord record = run_of(config("[1.05, 1.05]"), networks);
  ASSERT_EQ(record.certificate.guarantee, Guarantee::invariant);
  EXPECT_EQ(exit_code(record), 0);
  // An obstacle that {B <= 0} touches for some phases alone.
  record = run_of(config("[0.85, 0.0]"), networks);
  ASSERT_NE(record.certificate.guarantee, Guarantee::invariant);
  claim(record, networks);
  EXPECT_EQ(exit_code(record), 3);
}

TEST_F(Checker, SaysThatItDoesNotLookAtTheExecution) {
  const Certified certified = hand_made();
  const auto output_of = [&](const std::vector<std::string>& settings) {
    const std::string path = (folder_ / "run.h5").string(), out = (folder_ / "out").string();
    save_run(path, run_of(certified.config, certified.networks, nullptr, settings));
    EXPECT_EQ(std::system(fmt::format("'{}' '{}' >'{}'", S2NNDS_CHECK, path, out).c_str()), 0);
    std::ifstream stream(out);
    return std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  };
  const std::string said = "Not checked: [execution]";
  EXPECT_EQ(output_of({}).find(said), std::string::npos);
  EXPECT_NE(output_of({"execution.period=0.001"}).find(said), std::string::npos);
}

TEST_F(Checker, AgreesOnSomeMutations) { mutate(hand_made(), "hand-made", 60, 11); }
// One in 50 is of a trained run, whose check takes a hundred times as long.
TEST_F(Checker, DISABLED_AgreesOnManyMutations) {
  const char* count_text = std::getenv("S2NNDS_MUTATIONS");
  const char* seed_text = std::getenv("S2NNDS_MUTATIONS_SEED");
  const int count = count_text == nullptr ? 10000 : std::atoi(count_text);
  const std::uint64_t seed = seed_text == nullptr ? 11 : std::strtoull(seed_text, nullptr, 10);
  mutate(hand_made(), "hand-made", count - count / 50, seed);
  mutate(trained(), "trained", count / 50, seed);
}

}  // namespace
}  // namespace s2nnds

#endif
