// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace s2nnds::program {

// Sends spdlog's default logger to stderr, one plain line a message. Progress, warnings and errors go through
// it; results go to stdout.
void start_log();

}  // namespace s2nnds::program
