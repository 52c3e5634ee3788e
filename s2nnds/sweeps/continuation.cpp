#include "s2nnds/sweeps/continuation.h"

#include "s2nnds/core/check.h"
#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

void continue_run(const std::string& earlier, const std::string& text, const std::string& source,
                  const std::string& data_dir, const std::string& path) {
  RunRecord old = load_run(earlier);
  check(old.checkpoint.has_value(), "{}: found no checkpoint, expected one to go on from", earlier);
  const PreparedRun setup = prepare(parse_config(text, source), data_dir);
  RunRecord record = new_record(setup, text);
  record.networks = std::move(old.networks);
  record.history = std::move(old.history);
  record.checkpoint = std::move(old.checkpoint);
  record.checkpoint->finished = false;
  save_run(path, record);
}

}  // namespace s2nnds
