// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace s2nnds {

// Processors that this process may use (of its Slurm task, of its container's set).
int available_cores();

struct PoolJob {
  std::int64_t id = 0;
  std::vector<std::string> command;  // the program's path, then its arguments
  std::string log;                   // its stdout and stderr are appended here
};

struct PoolEnd {
  std::int64_t id = 0;
  int exit_code = 0;  // when no signal ended it
  int signal = 0;     // 0: it ended by itself
  double seconds = 0.0;
};

// Child processes, of which none outlives this process: the kernel kills them when it ends, however it ends.
// While a pool lives, SIGINT and SIGTERM are taken by wait(). To be used from one thread.
class ProcessPool {
 public:
  explicit ProcessPool(std::vector<std::pair<std::string, std::string>> environment);
  ~ProcessPool();  // kills those that still run
  ProcessPool(const ProcessPool&) = delete;
  ProcessPool& operator=(const ProcessPool&) = delete;

  void start(const PoolJob& job);  // throws Error when it cannot
  std::size_t running() const { return children_.size(); }

  // Waits until a child has ended, `seconds` are over or a signal came; a child's end, if there is one.
  std::optional<PoolEnd> wait(double seconds);
  bool interrupted() const { return interrupted_; }  // by SIGINT or SIGTERM
  void kill_all();

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
