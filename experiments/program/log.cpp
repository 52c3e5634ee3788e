// SPDX-License-Identifier: BSD-3-Clause
#include "log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace s2nnds::program {

void start_log() {
  const auto logger = spdlog::stderr_logger_mt("s2nnds");
  logger->set_pattern("%v");
  logger->flush_on(spdlog::level::info);  // whoever reads the progress of a run reads it line by line
  spdlog::set_default_logger(logger);
}

}  // namespace s2nnds::program
