// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/training/loss_part.h"

namespace s2nnds {

// The parts of the loss of LossOptions::kind.
LossTable loss_table(const LossOptions& options);

// The imitation term alone.
LossTable imitation_table();

}  // namespace s2nnds
