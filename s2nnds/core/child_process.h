// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <functional>
#include <mutex>
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

// A program that runs beside this one, in a process group of its own, without stdin. On Linux the kernel kills it when
// the thread that made this object ends: so make it and wait for it in one thread.
class RunningChild {
 public:
  // Starts the program at the path words[0] with the arguments words[1], ... Throws Error "WORDS[0]: cannot start:
  // reason".
  explicit RunningChild(const std::vector<std::string>& words);
  ~RunningChild();  // stops it, if it still runs
  RunningChild(const RunningChild&) = delete;
  RunningChild& operator=(const RunningChild&) = delete;

  // Calls `on_line` for each line of its stderr as it comes, and returns when the program has ended. To be called
  // once, by the thread that started it. Of stdout and stderr the last megabyte is kept.
  ChildResult wait(const std::function<void(const std::string&)>& on_line);
  // From any thread: kills its process group, if it still runs. wait() then returns.
  void stop();

 private:
  ChildResult finish();  // waits for the process itself

  std::string name_;
  std::mutex mutex_;
  pid_t child_ = 0;  // 0: it has ended
  int output_ = -1, errors_ = -1;
};

}  // namespace s2nnds
