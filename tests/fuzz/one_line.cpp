// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fuzz/one_line.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "s2nnds/core/check.h"

namespace s2nnds::fuzz {
namespace {

// Everything that C code of this process prints while it lives. The fuzzer and the sanitizers write by other
// ways, so that their reports still come through.
class Printed {
 public:
  Printed() {
    stream_ = std::tmpfile();
    if (stream_ == nullptr) std::abort();
    stderr = stream_;
    stdout = stream_;
  }
  std::string take() {
    std::fflush(stream_);
    std::string text(static_cast<std::size_t>(std::ftell(stream_)), '\0');
    if (text.empty()) return text;
    std::rewind(stream_);
    text.resize(std::fread(text.data(), 1, text.size(), stream_));
    std::rewind(stream_);
    return text;
  }

 private:
  std::FILE* stream_ = nullptr;
};

[[noreturn]] void stop(const std::string& what, const std::string& text) {
  const std::string line = what + ": \"" + text + "\"\n";
  if (::write(STDERR_FILENO, line.data(), line.size()) < 0) std::abort();
  std::abort();
}

bool is_one_line(const std::string& text) {
  if (text.empty() || text.size() > 2000) return false;
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) return false;
  }
  return true;
}

}  // namespace

void expect_one_line(const std::function<void()>& read) {
  static Printed printed;
  try {
    read();
  } catch (const Error& error) {
    if (!is_one_line(error.what())) stop("not one line", error.what());
  }
  if (const std::string text = printed.take(); !text.empty()) stop("printed", text);
}

std::string file_of(const std::uint8_t* data, std::size_t size, const std::string& ending) {
  static const std::filesystem::path folder = std::filesystem::exists("/dev/shm")
                                                  ? std::filesystem::path("/dev/shm")
                                                  : std::filesystem::temp_directory_path();
  static const std::string path = (folder / ("s2nnds-fuzz-" + std::to_string(::getpid()))).string() + ending;
  static const int at_exit = std::atexit([] { ::unlink(path.c_str()); });
  static_cast<void>(at_exit);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return path;
}

}  // namespace s2nnds::fuzz
