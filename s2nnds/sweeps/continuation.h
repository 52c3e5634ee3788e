#pragma once

#include <string>

#include "s2nnds/core/options.h"

namespace s2nnds {

// Begins a run of the configuration `text` at `path` where the run `earlier`, of the same configuration with
// fewer training.rounds, ended: trained further, it is the run that it would be from the start, since a round
// depends only on the rounds before it. Throws Error when `earlier` cannot be read or has no checkpoint.
void continue_run(const std::string& earlier, const std::string& text, const std::string& source,
                  const std::string& data_dir, const std::string& path);

}  // namespace s2nnds
