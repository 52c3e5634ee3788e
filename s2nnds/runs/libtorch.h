// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

namespace s2nnds {

// Whether LibTorch is linked to this program. Without it (deployment/without_libtorch.cpp), train() and
// torchscript_module() throw Error.
bool has_libtorch();

// Sets how many threads each operation on tensors may use, >= 1. Without LibTorch it does nothing.
void set_tensor_threads(int threads);

// The present number; none without LibTorch.
std::optional<int> tensor_threads();

}  // namespace s2nnds
