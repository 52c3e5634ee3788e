#include "s2nnds/core/atomic_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

bool write_file(const std::string& path, const std::string& bytes) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return false;
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size() &&
                       std::fflush(file) == 0 && ::fsync(::fileno(file)) == 0;
  return std::fclose(file) == 0 && written;
}

}  // namespace

void write_atomic_file(const std::string& path, const std::string& bytes, const std::string& what) {
  const std::string temporary = fmt::format("{}.{}.partial", path, ::getpid());
  errno = 0;
  if (write_file(temporary, bytes) && std::rename(temporary.c_str(), path.c_str()) == 0) return;
  const std::string reason = std::strerror(errno);
  std::remove(temporary.c_str());
  fail("{}: cannot write {}: {}", path, what, reason);
}

}  // namespace s2nnds
