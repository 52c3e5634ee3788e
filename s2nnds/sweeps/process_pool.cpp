// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/process_pool.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "s2nnds/core/check.h"
#include "s2nnds/core/platform.h"

extern char** environ;

namespace s2nnds {
namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<std::string> environment_with(const std::vector<std::pair<std::string, std::string>>& changes) {
  std::vector<std::string> all;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    const bool changed = std::any_of(changes.begin(), changes.end(), [&](const auto& change) {
      return text.starts_with(change.first + "=");
    });
    if (!changed) all.push_back(text);
  }
  for (const auto& [name, value] : changes) all.push_back(name + "=" + value);
  return all;
}

std::vector<char*> pointers(const std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (const std::string& text : texts) all.push_back(const_cast<char*>(text.c_str()));
  all.push_back(nullptr);
  return all;
}

// In the child, between fork and exec: system calls only. Its own process group keeps a Ctrl-C of the
// terminal from it.
[[noreturn]] void become(char** arguments, char** environment, int log, pid_t parent, const sigset_t& mask) {
  ::setpgid(0, 0);
  end_with_parent();
  if (::getppid() != parent) ::_exit(127);  // the parent has ended already
  ::sigprocmask(SIG_SETMASK, &mask, nullptr);
  ::dup2(log, STDOUT_FILENO);
  ::dup2(log, STDERR_FILENO);
  ::execve(arguments[0], arguments, environment);
  ::_exit(127);
}

}  // namespace

ProcessPool::ProcessPool(std::vector<std::pair<std::string, std::string>> environment)
    : environment_(environment_with(environment)) {
  ::sigemptyset(&watched_);
  for (const int signal : {SIGCHLD, SIGINT, SIGTERM}) ::sigaddset(&watched_, signal);
  ::sigprocmask(SIG_BLOCK, &watched_, &before_);
}

ProcessPool::~ProcessPool() {
  kill_all();
  ::sigprocmask(SIG_SETMASK, &before_, nullptr);
}

void ProcessPool::start(const PoolJob& job) {
  check(!job.command.empty() && ::access(job.command[0].c_str(), X_OK) == 0,
        "{}: cannot start it: expected a program", job.command.empty() ? "" : job.command[0]);
  const int log = ::open(job.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  check(log >= 0, "{}: cannot write it: {}", job.log, std::strerror(errno));
  const std::vector<char*> arguments = pointers(job.command);
  const std::vector<char*> environment = pointers(environment_);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) {
    become(const_cast<char**>(arguments.data()), const_cast<char**>(environment.data()), log, parent,
           before_);
  }
  ::close(log);
  check(child > 0, "{}: cannot start it: {}", job.command[0], std::strerror(errno));
  ::setpgid(child, child);  // here too, so that it holds whoever comes first
  children_.push_back({job.id, child, now()});
}

std::optional<PoolEnd> ProcessPool::take_ended() {
  for (auto child = children_.begin(); child != children_.end(); ++child) {
    int status = 0;
    if (::waitpid(child->pid, &status, WNOHANG) != child->pid) continue;
    PoolEnd end;
    end.id = child->id;
    end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
    end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    end.seconds = now() - child->began;
    children_.erase(child);
    return end;
  }
  return std::nullopt;
}

std::optional<PoolEnd> ProcessPool::wait(double seconds) {
  const double until = now() + seconds;
  while (true) {
    if (const auto end = take_ended()) return end;
    const double left = until - now();
    if (left <= 0.0 || interrupted_) return std::nullopt;
    const int signal = wait_for_signal(watched_, left);
    if (signal == SIGINT || signal == SIGTERM) interrupted_ = true;
  }
}

void ProcessPool::kill_all() {
  for (const Child& child : children_) ::kill(-child.pid, SIGKILL);
  for (const Child& child : children_) ::waitpid(child.pid, nullptr, 0);
  children_.clear();
}

}  // namespace s2nnds
