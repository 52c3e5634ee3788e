// SPDX-License-Identifier: BSD-3-Clause
#include "python_script.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "commands.h"
#include "s2nnds/core/check.h"

extern char** environ;

namespace s2nnds::program {

int run_python(const std::string& command, const std::string& script,
               const std::vector<std::string>& arguments) {
  const char* wish = std::getenv("S2NNDS_PYTHON");
  const std::string python = wish ? wish : "/usr/bin/python3";
  std::vector<std::string> words = {python, script};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::fflush(nullptr);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, python.c_str(), nullptr, nullptr, argv.data(), environ);
  check(error == 0, "{}: cannot start {} (set S2NNDS_PYTHON to a Python with matplotlib and h5py)", command,
        python);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : kInternalFailure;
}

}  // namespace s2nnds::program
