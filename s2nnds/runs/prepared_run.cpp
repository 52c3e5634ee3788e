#include "s2nnds/runs/prepared_run.h"

#include "s2nnds/runs/version.h"

namespace s2nnds {

PreparedRun prepare(const Config& config, const std::string& data_dir) {
  PreparedRun setup;
  setup.config = config;
  setup.raw = read_demonstrations(config.data, data_dir);
  setup.normalization = find_normalization(config.data.normalization, setup.raw.demonstrations);
  setup.demonstrations = normalize(setup.raw.demonstrations, setup.normalization);
  setup.split = split_demonstrations(setup.demonstrations.size(), config.data.test, config.data.validation);
  setup.problem = make_problem(config.problem, setup.demonstrations, data_dir);
  return setup;
}

PreparedRun prepare(const RunRecord& record, const std::string& data_dir) {
  PreparedRun setup;
  setup.config = parse_config(record.config.resolved, "the run's configuration");
  setup.normalization = record.data.normalization;
  setup.split = record.data.split;
  setup.demonstrations = record.data.normalized();
  setup.problem = make_problem(setup.config.problem, setup.demonstrations, data_dir);
  return setup;
}

RunRecord new_record(const PreparedRun& setup, const std::string& text) {
  RunRecord record;
  record.program_version = program_version();
  record.library_versions = library_versions();
  record.created = time_stamp();
  record.name = setup.config.name;
  record.seed = setup.config.seed;
  record.config = {text, to_toml(setup.config), flatten(setup.config)};
  record.data.unit = setup.raw.unit;
  record.data.dimension = setup.problem.dimension();
  record.data.normalization = setup.normalization;
  record.data.split = setup.split;
  record.data.demonstrations = setup.demonstrations;
  for (std::size_t k = 0; k < record.data.demonstrations.size(); ++k) {
    record.data.demonstrations[k].time = setup.raw.demonstrations[k].time;
  }
  record.problem = {setup.problem.unsafe->describe(), setup.problem.initial->describe(),
                    setup.problem.workspace_margin ? setup.problem.containment : 0.0,
                    setup.config.training.level_band, setup.problem.workspace};
  return record;
}

}  // namespace s2nnds
