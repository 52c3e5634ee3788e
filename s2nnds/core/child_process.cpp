// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/child_process.h"

#include <fcntl.h>
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
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace s2nnds
