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
#include "s2nnds/runs/verification_run.h"
#include "tests/verification/hand_made_system.h"

namespace s2nnds {
namespace {

constexpr const char* kConfig = R"(
name = "checked"
[data]
source = "handwriting"
[problem]
frame = "normalised"
initial = {{ type = "ball", center = [0.3, -0.2], radius = {} }}
unsafe = {{ type = "ball", center = [{}, 1.05], radius = 0.1 }}
[training]
level_band = {}
)";

RunRecord run_of(const std::string& config, const Networks& networks, ProofCovers* covers = nullptr) {
  const PreparedRun setup = prepare(parse_config(config, "a test"), "");
  RunRecord record = new_record(setup, config);
  record.networks = networks;
  VerificationOptions options = setup.config.verification;
  options.proof.max_boxes = 100000;
  verify(setup, record, Method::proof, options, nullptr, covers);
  return record;
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
  void mutate(int count, std::uint64_t seed) const {
    int accepted = 0, rejected = 0, neither = 0;
    RandomStream random(seed, "mutations");
    for (int k = 0; k < count; ++k) {
      Networks networks = simple_networks();
      double radius = 0.2, center = 1.05, band = 0.01;
      const std::size_t kind = random.below(5);
      const double size = std::pow(10.0, random.uniform(-3.0, 1.0)), change = random.uniform(-size, size);
      if (kind == 0) radius += 0.5 * std::abs(change);
      if (kind == 1) center += 0.2 * change;
      if (kind == 2) band *= 1.0 + 20.0 * std::abs(change);
      if (kind > 2) {
        NetworkWeights* changed[] = {&networks.f, &networks.V, &networks.B};
        Layer& layer = changed[random.below(3)]->layers.front();
        layer.weight.data()[random.below(static_cast<std::size_t>(layer.weight.size()))] += change;
      }
      RunRecord record;
      try {
        record = run_of(fmt::format(kConfig, radius, center, band), networks);
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
        "{} mutations of seed {}: {} still true by the checker, {} rejected by the prover, {} neither\n",
        count, seed, accepted, rejected, neither);
    EXPECT_GT(accepted, count / 50);
    EXPECT_GT(rejected, count / 50);
  }

  std::filesystem::path folder_;
};

TEST_F(Checker, ShowsWhatTheProverProved) {
  const RunRecord record = run_of(fmt::format(kConfig, 0.2, 1.05, 0.01), simple_networks());
  ASSERT_EQ(record.certificate.guarantee, Guarantee::invariant);
  EXPECT_EQ(exit_code(record), 0);
}

TEST_F(Checker, DoesNotShowWhatIsFalse) {
  RunRecord record = run_of(fmt::format(kConfig, 0.2, 1.05, 0.01), simple_networks());
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
  const RunRecord record = run_of(fmt::format(kConfig, 0.2, 1.05, 0.01), simple_networks(), &covers);
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
  RunRecord record = run_of(fmt::format(kConfig, 0.2, 1.05, 0.01), simple_networks());
  Networks other = simple_networks();
  other.B.layers.front().activation = Activation::elu;
  claim(record, other);
  EXPECT_EQ(exit_code(record), 2);
}

TEST_F(Checker, AgreesOnSomeMutations) { mutate(60, 11); }
TEST_F(Checker, DISABLED_AgreesOnManyMutations) {
  const char* count = std::getenv("S2NNDS_MUTATIONS");
  const char* seed = std::getenv("S2NNDS_MUTATIONS_SEED");
  mutate(count == nullptr ? 10000 : std::atoi(count),
         seed == nullptr ? 11 : std::strtoull(seed, nullptr, 10));
}

}  // namespace
}  // namespace s2nnds

#endif
