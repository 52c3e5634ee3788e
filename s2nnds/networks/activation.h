// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace s2nnds {

// The functions that layers apply to each number. elu is x for x > 0 and exp(x) - 1 otherwise; silu is
// x / (1 + exp(-x)); softplus is log(1 + exp(x)).
enum class Activation { identity, tanh, elu, softplus, silu, sine };

}  // namespace s2nnds
