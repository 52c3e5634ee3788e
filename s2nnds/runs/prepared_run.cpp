// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/prepared_run.h"

#include <fmt/format.h>

#include "s2nnds/core/check.h"
#include "s2nnds/data/phase.h"
#include "s2nnds/runs/version.h"

namespace s2nnds {
namespace {

// What the dimension makes of a configuration that leaves it open; "" in up to four dimensions.
std::string choice_in_words(const Config& config, std::int64_t dimension) {
  Config chosen = config;
  chosen.choose_for(dimension);
  if (config.networks.f.form == chosen.networks.f.form || chosen.networks.f.form != "projected") return "";
  return fmt::format(
      "{} dimensions: networks.f.form = projected, so that convergence is proved by construction; what "
      "concerns "
      "the obstacle is checked at drawn points (verification.method = {})",
      dimension, to_string(*chosen.verification.method));
}

}  // namespace

PreparedRun prepare(Config config, RunData data, RegionFiles files) {
  config.choose_for(data.dimension);
  config.check_forms();
  PreparedRun setup{.config = std::move(config),
                    .data = std::move(data),
                    .demonstrations = {},
                    .problem = {},
                    .files = std::move(files)};
  check(!setup.data.frame.has_phase() ||
            (setup.config.execution.is_ideal() && !(setup.config.execution.damping > 0.0)),
        "execution: found a model of how a robot executes the motion, whose states have a phase; expected "
        "none: a phase does not lag as a robot does (data.state = \"position\" is without)");
  setup.demonstrations = setup.data.normalized();
  setup.problem = make_problem(setup.config.problem, setup.demonstrations, setup.data.frame, setup.files);
  return setup;
}

PreparedRun prepare(const Config& config, DemonstrationSet as_read, RegionFiles files) {
  RunData data;
  data.frame = find_state(as_read, config.data.state, config.data.normalization, config.data.goal);
  data.dimension = as_read.dimension();
  data.frame.name = config.data.frame_name;
  data.split = split_demonstrations(as_read.demonstrations.size(), config.data.test, config.data.validation);
  data.demonstrations = std::move(as_read.demonstrations);
  data.report = std::move(as_read.report);
  if (const std::string line = choice_in_words(config, data.dimension); !line.empty())
    data.report.push_back(line);
  return prepare(config, std::move(data), std::move(files));
}

PreparedRun prepare(const Config& config, const std::string& data_dir, const ReadingProgress& progress) {
  return prepare(config, read_demonstrations(config.data, data_dir, progress), RegionFiles(data_dir));
}

PreparedRun prepare(const RunRecord& record) {
  return prepare(parse_config(record.config.resolved, "the run's configuration"), record.data,
                 RegionFiles(record.problem.files));
}

RunRecord new_record(const PreparedRun& setup, const std::string& text) {
  RunRecord record;
  record.program_version = program_version();
  record.library_versions = library_versions();
  record.created = time_stamp();
  record.name = setup.config.name;
  record.seed = setup.config.seed;
  record.config = {text, to_toml(setup.config), flatten(setup.config)};
  record.data = setup.data;
  record.problem = {setup.config.problem.frame,
                    setup.problem.unsafe->describe(),
                    setup.problem.initial->describe(),
                    setup.config.problem.containment,
                    setup.config.training.level_band,
                    setup.problem.workspace,
                    setup.files.all()};
  return record;
}

}  // namespace s2nnds
