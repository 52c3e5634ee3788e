// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace s2nnds {

// A command that a pool is to run.
struct PoolJob {
  std::int64_t id = 0;               // the caller's own, comes back in PoolEnd
  std::vector<std::string> command;  // the program's path, then its arguments
  std::string log;                   // its stdout and stderr are appended here
};

// How a child process ended.
struct PoolEnd {
  std::int64_t id = 0;   // PoolJob::id
  int exit_code = 0;     // when no signal ended it
  int signal = 0;        // 0: it ended by itself
  double seconds = 0.0;  // wall clock since its start
};

// Child processes, of which none outlives this process: the kernel kills them when it ends, however it ends
// (on macOS not if it is killed by SIGKILL).
// While a pool lives, SIGINT and SIGTERM are taken by wait(). To be used from one thread.
class ProcessPool {
 public:
  // (name, value) of variables that the children get on top of this process's environment.
  explicit ProcessPool(std::vector<std::pair<std::string, std::string>> environment);
  ~ProcessPool();  // kills those that still run
  ProcessPool(const ProcessPool&) = delete;
  ProcessPool& operator=(const ProcessPool&) = delete;

  void start(const PoolJob& job);                           // throws Error when it cannot
  std::size_t running() const { return children_.size(); }  // children whose end wait() has not told yet

  // Waits until a child has ended, `seconds` are over or a signal came; a child's end, if there is one.
  std::optional<PoolEnd> wait(double seconds);
  bool interrupted() const { return interrupted_; }  // by SIGINT or SIGTERM
  void kill_all();                                   // with SIGKILL, and waits for their end

 private:
  struct Child {
    std::int64_t id;
    int pid;
    double began;
  };
  std::optional<PoolEnd> take_ended();

  std::vector<std::string> environment_;  // NAME=value
  std::vector<Child> children_;
  bool interrupted_ = false;
  sigset_t watched_;
  sigset_t before_;
};

}  // namespace s2nnds
