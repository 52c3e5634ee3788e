// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

bool write_all(int file, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = ::write(file, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return ::fsync(file) == 0;
}

// A new name lasts only once its directory is on the disk as well. The file is whole either way.
void flush_directory(const std::string& path) {
  const std::string directory = std::filesystem::path(path).parent_path().string();
  const int folder = ::open(directory.empty() ? "." : directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  ::fsync(folder);
  ::close(folder);
}

}  // namespace

void write_atomic_file(const std::string& path, const std::string& bytes, const std::string& what) {
  std::string partial;
  int file = -1;
  int attempt = 0;
  do {  // process numbers are not unique on a disk that several machines share
    partial = fmt::format("{}.{}-{}.partial", path, ::getpid(), attempt++);
    file = ::open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (file < 0 && errno == EEXIST);
  if (file < 0) fail("{}: cannot write {}: {}", path, what, std::strerror(errno));
  bool done = write_all(file, bytes);
  int error = done ? 0 : errno;
  if (::close(file) != 0 && done) done = false, error = errno;
  if (done && std::rename(partial.c_str(), path.c_str()) == 0) return flush_directory(path);
  if (done) error = errno;
  ::unlink(partial.c_str());
  fail("{}: cannot write {}: {}", path, what, std::strerror(error));
}

}  // namespace s2nnds
