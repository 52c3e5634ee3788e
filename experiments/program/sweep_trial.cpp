// SPDX-License-Identifier: BSD-3-Clause
#include "sweep_trial.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "need_libtorch.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/settings.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/config.h"
#include "s2nnds/runs/prepared_run.h"
#include "s2nnds/runs/summary.h"
#include "s2nnds/sweeps/trial_result.h"

namespace s2nnds::program {
namespace {

namespace fs = std::filesystem;

// Beta is split over the trials before any data are read, so what the dimension would choose may not be conformal.
std::vector<std::string> settings_of(const Sweep& sweep, const Trial& trial) {
  std::vector<std::string> settings = sweep.settings(trial);
  const BaseConfig& base = sweep.configs[static_cast<std::size_t>(trial.config)];
  if (!parse_config(base.text, base.path, settings).verification.method)
    settings.push_back("verification.method=\"proof\"");
  return settings;
}

// Begins the trial where the rung before ended its run of the same configuration with fewer rounds. Trained
// further, it is the run that it would be from the start, since a round depends only on the rounds before it.
void take_over(const Sweep& sweep, const SweepFolder& folder, const Trial& trial,
               const CommonArguments& common) {
  if (trial.rung == 0 || sweep.options.halving.key != "training.rounds") return;
  const std::string earlier = folder.run(trial.id - sweep.trials_a_rung());
  if (!fs::exists(earlier)) return;
  const std::string config = folder.config(sweep.configs[trial.config]);
  RunRecord old = load_run(earlier);
  check(old.checkpoint.has_value(), "{}: found no checkpoint, expected one to go on from", earlier);
  const std::string text = with_settings(read_config_text(config), config, settings_of(sweep, trial));
  RunRecord record = new_record(prepare(parse_config(text, config), data_directory(common.data)), text);
  record.networks = std::move(old.networks);
  record.history = std::move(old.history);
  record.checkpoint = std::move(old.checkpoint);
  record.checkpoint->finished = false;
  save_run(folder.run(trial.id), record);
}

int train_trial(const Sweep& sweep, const SweepFolder& folder, const Trial& trial,
                const CommonArguments& common) {
  TrainArguments arguments;
  const std::string run = folder.run(trial.id);
  if (!fs::exists(run)) take_over(sweep, folder, trial, common);
  if (fs::exists(run)) {
    arguments.resume = run;
  } else {
    arguments.config = folder.config(sweep.configs[trial.config]);
    arguments.assignments = settings_of(sweep, trial);
    arguments.out = run;
  }
  return train(arguments, common);
}

}  // namespace

int run_trial(const Sweep& sweep, const SweepFolder& folder, std::int64_t id, const CommonArguments& common) {
  need_libtorch(common);
  const auto began = std::chrono::steady_clock::now();
  const Trial trial = sweep.trial(id);
  folder.make_run_folder(id);
  TrialResult result;
  result.trial = id;
  int code = kVerified;
  try {
    code = train_trial(sweep, folder, trial, common);
    take_summary(summary_json(load_certified_run(folder.run(id)), folder.run(id)), result);
  } catch (const std::exception& error) {
    const bool refused = dynamic_cast<const Error*>(&error) != nullptr;
    result.failed = true;
    result.error = refused ? error.what() : fmt::format("internal failure: {}", error.what());
    fmt::print(stderr, "s2nnds: {}\n", result.error);
    code = refused ? kBadInput : kInternalFailure;
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  write_result(folder.result(id), result);
  return code;
}

}  // namespace s2nnds::program
