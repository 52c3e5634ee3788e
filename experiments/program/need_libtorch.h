// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "commands.h"

namespace s2nnds::program {

// For commands that need LibTorch, before they do anything. The program s2nnds is not linked to it, to start at
// once; there, s2nnds-torch, which lies beside it and is, takes its place in this process, and begins again with the
// same words. Throws Error when that cannot be started. In s2nnds-torch this does nothing.
void need_libtorch(const CommonArguments& common);

}  // namespace s2nnds::program
