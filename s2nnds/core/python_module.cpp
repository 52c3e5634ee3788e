// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/python_module.h"

#include <spawn.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "s2nnds/core/check.h"
#include "s2nnds/core/platform.h"

extern char** environ;

namespace s2nnds {
namespace {

namespace fs = std::filesystem;

// This process's environment, in which Python finds the package in `folder` and looks for nothing in the working
// directory.
std::vector<std::string> environment_with(const std::string& folder) {
  std::vector<std::string> lines;
  for (char** line = environ; *line != nullptr; ++line) {
    if (!std::string(*line).starts_with("PYTHONPATH=")) lines.emplace_back(*line);
  }
  const char* before = std::getenv("PYTHONPATH");
  lines.push_back("PYTHONPATH=" + folder + (before && *before ? ":" + std::string(before) : ""));
  lines.emplace_back("PYTHONSAFEPATH=1");
  return lines;
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  return argv;
}

}  // namespace

std::string python_package() {
  const fs::path beside = fs::path(code_path()).parent_path() / "s2nnds";
  std::error_code error;
  const fs::path package = fs::canonical(beside, error).parent_path();
  check(!error && fs::exists(package / "__init__.py"),
        "{}: found no program there that lies in the Python package s2nnds, expected it for figures",
        beside.string());
  return package.string();
}

std::string python_program() {
  const char* wish = std::getenv("S2NNDS_PYTHON");
  return wish ? wish : "/usr/bin/python3";
}

int run_python_module(const std::string& command, const std::string& name,
                      const std::vector<std::string>& arguments) {
  const std::string python = python_program();
  std::vector<std::string> words = {python, "-m", "s2nnds." + name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> environment = environment_with(fs::path(python_package()).parent_path());
  std::fflush(nullptr);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, python.c_str(), nullptr, nullptr, pointers(words).data(),
                                  pointers(environment).data());
  check(error == 0, "{}: cannot start {} (set S2NNDS_PYTHON to a Python with matplotlib and h5py)", command,
        python);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace s2nnds
