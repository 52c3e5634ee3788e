// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace s2nnds {

// How a program that was started ended, and what it wrote.
struct ChildResult {
  int exit_code = 0;   // 128 + N if signal N ended it, as shells say it
  std::string output;  // all that it wrote to stdout
  std::string errors;  // all that it wrote to stderr
};

// Starts the program words[0], looked up in PATH if it has no slash, with the arguments words[1], ..., gives it
// `input` on stdin and waits for its end. It need not read its input. Nothing goes through files, and the
// sizes have no limit. Throws Error "WORDS[0]: cannot start: reason".
ChildResult run_child(const std::vector<std::string>& words, const std::string& input);

}  // namespace s2nnds
