#pragma once

#include <functional>
#include <string>

#include "s2nnds/runs/config.h"
#include "s2nnds/runs/run_record.h"
#include "s2nnds/training/trainer.h"

namespace s2nnds {

// The steps from a configuration to a certified run, as the command line and the drivers string them
// together.

// A configuration made concrete: data read, normalised and split, the sets built and checked.
struct PreparedRun {
  Config config;
  DemonstrationSet raw;
  Normalization normalization;
  Split split;
  std::vector<Demonstration> demonstrations;  // normalised, all of them
  SafetyProblem problem;

  std::vector<Demonstration> train() const { return select(demonstrations, split.train); }
  std::vector<Demonstration> test() const { return select(demonstrations, split.test); }
  std::vector<Demonstration> validation() const { return select(demonstrations, split.validation); }
};
// Throws Error for whatever is wrong with the data or the sets.
PreparedRun prepare(const Config& config, const std::string& data_dir);
// The sets of a stored run, from its own configuration and demonstrations.
PreparedRun prepare(const RunRecord& record, const std::string& data_dir);

// A record with all that is known before training. `text` is the configuration as the user gave it.
RunRecord new_record(const PreparedRun& setup, const std::string& text);

struct TrainingHooks {
  std::function<void(const RoundSummary&)> progress;  // after the warm start and every round
  std::function<void(const RunRecord&)> checkpoint;   // the record so far, at the same moments
};
// Trains from where the record's checkpoint stands (from the start if it has none) and fills in networks,
// history and checkpoint. Returns whether the last round ended clean.
TrainerSummary train(const PreparedRun& setup, RunRecord& record, const TrainingHooks& hooks);

// Verifies the record's networks by "sampled", "conformal" or "proof" and updates its certificate: the
// guarantee is the strongest one that these weights have passed. Each conformal call is a further attempt,
// which spends its share of beta. `progress` hears of the proof's levels.
void verify(const PreparedRun& setup, RunRecord& record, const std::string& method,
            const VerificationOptions& options, const ProofProgress& progress = nullptr);

// Fills in errors, areas, the rollouts from the demonstrations' first points, and the grid for figures.
void evaluate(const PreparedRun& setup, RunRecord& record);

// One JSON object: name, seed, guarantee, conditions{}, seconds{}, mse_train, mse_test, sd_test, safe_area,
// true_safe_area, run, and more. Numbers that were not measured are null.
std::string summary_json(const RunRecord& record, const std::string& path);

// What is guaranteed, in words.
std::string guarantee_statement(const RunRecord& record);

}  // namespace s2nnds
