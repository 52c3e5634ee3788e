// SPDX-License-Identifier: BSD-3-Clause
#include "need_libtorch.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "s2nnds/core/check.h"
#include "s2nnds/core/platform.h"
#include "s2nnds/runs/libtorch.h"

namespace s2nnds::program {

void need_libtorch(const CommonArguments& common) {
  if (has_libtorch()) return;
  const std::string path = std::filesystem::path(executable_path()).replace_filename("s2nnds-torch").string();
  std::fflush(nullptr);
  ::execv(path.c_str(), common.words);
  fail("cannot start {}, which has LibTorch: {}", path, std::strerror(errno));
}

}  // namespace s2nnds::program
