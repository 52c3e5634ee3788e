// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/libtorch.h"

#include <ATen/Parallel.h>

namespace s2nnds {

bool has_libtorch() { return true; }

void set_tensor_threads(int threads) { at::set_num_threads(threads); }

std::optional<int> tensor_threads() { return at::get_num_threads(); }

}  // namespace s2nnds
