// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <thread>
#include <utility>

#include "s2nnds/core/check.h"
#include "s2nnds/core/platform.h"

extern char** environ;

namespace s2nnds {
namespace {

// Both ends of a pipe; no other child inherits them.
class Pipe {
 public:
  explicit Pipe(const std::string& program) {
    check(::pipe(ends_) == 0, "{}: cannot start: {}", program, std::strerror(errno));
    for (const int end : ends_) ::fcntl(end, F_SETFD, FD_CLOEXEC);
  }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int reading() const { return ends_[0]; }
  int take_reading() { return std::exchange(ends_[0], -1); }  // the caller closes it
  int writing() const { return ends_[1]; }
  void close_reading() { close_end(0); }
  void close_writing() { close_end(1); }

 private:
  void close_end(int end) {
    if (ends_[end] >= 0) ::close(std::exchange(ends_[end], -1));
  }

  int ends_[2] = {-1, -1};
};

std::string read_all(int from) {
  std::string text;
  std::array<char, 65536> part{};
  for (;;) {
    const ssize_t count = ::read(from, part.data(), part.size());
    if (count > 0) text.append(part.data(), static_cast<std::size_t>(count));
    if (count == 0 || (count < 0 && errno != EINTR)) return text;
  }
}

// Stops without a word when nobody reads any more: how the child ends tells what went wrong.
void write_all(int to, const std::string& text) {
  sigset_t broken_pipe;
  sigemptyset(&broken_pipe);
  sigaddset(&broken_pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &broken_pipe, nullptr);  // of this thread alone, which ends here
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = ::write(to, text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR) return;
    if (count > 0) done += static_cast<std::size_t>(count);
  }
}

// With the three pipes as its stdin, stdout and stderr.
pid_t start(const std::vector<std::string>& words, const Pipe& input, const Pipe& output,
            const Pipe& errors) {
  std::vector<std::string> copies = words;
  std::vector<char*> arguments;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input.reading(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output.writing(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, errors.writing(), STDERR_FILENO);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  check(error == 0, "{}: cannot start: {}", words[0], std::strerror(error));
  return child;
}

constexpr std::size_t kKept = 1 << 20;  // bytes of a running child's stdout and stderr

// Appends, and forgets what came first.
void keep(std::string& all, const char* part, std::size_t count) {
  all.append(part, count);
  if (all.size() > 2 * kKept) all.erase(0, all.size() - kKept);
}

// In the child, between fork and exec: system calls only.
[[noreturn]] void become(char** arguments, int output, int errors, pid_t parent) {
  ::setpgid(0, 0);
  end_with_parent();
  if (::getppid() != parent) ::_exit(127);  // the parent has ended already
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = ::open("/dev/null", O_RDONLY);
  if (nothing >= 0) ::dup2(nothing, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(errors, STDERR_FILENO);
  ::execv(arguments[0], arguments);
  ::_exit(127);
}

int exit_code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

}  // namespace

ChildResult run_child(const std::vector<std::string>& words, const std::string& input) {
  check(!words.empty(), "run_child: found no program to start");
  Pipe in(words[0]), out(words[0]), err(words[0]);
  const pid_t child = start(words, in, out, err);
  in.close_reading();
  out.close_writing();
  err.close_writing();
  ChildResult result;
  // All at once, or a full pipe would block the child, and the child us.
  std::thread writer([&] {
    write_all(in.writing(), input);
    in.close_writing();
  });
  std::thread reader([&] { result.errors = read_all(err.reading()); });
  result.output = read_all(out.reading());
  writer.join();
  reader.join();
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    check(errno == EINTR, "{}: cannot tell how it ended: {}", words[0], std::strerror(errno));
  result.exit_code = exit_code_of(status);
  return result;
}

RunningChild::RunningChild(const std::vector<std::string>& words) {
  check(!words.empty(), "RunningChild: found no program to start");
  name_ = words[0];
  check(::access(name_.c_str(), X_OK) == 0, "{}: cannot start: {}", name_, std::strerror(errno));
  Pipe out(name_), err(name_);
  std::vector<std::string> copies = words;
  std::vector<char*> arguments;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) become(arguments.data(), out.writing(), err.writing(), parent);
  check(child > 0, "{}: cannot start: {}", name_, std::strerror(errno));
  ::setpgid(child, child);  // here too, so that it holds whoever comes first
  child_ = child;
  output_ = out.take_reading();
  errors_ = err.take_reading();
}

RunningChild::~RunningChild() {
  stop();
  if (child_ != 0) finish();
  ::close(output_);
  ::close(errors_);
}

ChildResult RunningChild::wait(const std::function<void(const std::string&)>& on_line) {
  std::string output, errors, line;
  std::array<char, 65536> part{};
  pollfd ends[2] = {{output_, POLLIN, 0}, {errors_, POLLIN, 0}};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (::poll(ends, 2, -1) < 0) {
      check(errno == EINTR, "{}: cannot read what it says: {}", name_, std::strerror(errno));
      continue;
    }
    for (pollfd& end : ends) {
      if (end.fd < 0 || end.revents == 0) continue;
      const ssize_t count = ::read(end.fd, part.data(), part.size());
      if (count == 0 || (count < 0 && errno != EINTR)) end.fd = -1;
      if (count <= 0) continue;
      const auto size = static_cast<std::size_t>(count);
      keep(&end == &ends[0] ? output : errors, part.data(), size);
      if (&end == &ends[0]) continue;
      for (std::size_t i = 0; i < size; ++i) {
        if (part[i] != '\n') {
          if (line.size() < kKept) line += part[i];
          continue;
        }
        on_line(line);
        line.clear();
      }
    }
  }
  if (!line.empty()) on_line(line);
  ChildResult result = finish();
  result.output = std::move(output);
  result.errors = std::move(errors);
  return result;
}

ChildResult RunningChild::finish() {
  ChildResult result;
  siginfo_t ended;
  // It stays a zombie until the lock is held, so that stop() never kills another process of its number.
  while (::waitid(P_PID, static_cast<id_t>(child_), &ended, WEXITED | WNOWAIT) < 0)
    check(errno == EINTR, "{}: cannot tell how it ended: {}", name_, std::strerror(errno));
  const std::lock_guard lock(mutex_);
  int status = 0;
  ::kill(-child_, SIGKILL);  // whoever of its group is left
  ::waitpid(child_, &status, 0);
  child_ = 0;
  result.exit_code = exit_code_of(status);
  return result;
}

void RunningChild::stop() {
  const std::lock_guard lock(mutex_);
  if (child_ != 0) ::kill(-child_, SIGKILL);
}

}  // namespace s2nnds
