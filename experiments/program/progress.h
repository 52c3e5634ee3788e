// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/training/trainer.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds::program {

// Logs one line a round: losses, counterexamples by condition, time. A terminal gets a header and
// columns, a pipe plain "key=value" lines.
void print_round(const RoundSummary& row);

// Logs how much of a large data file has been read: a share in [0, 1].
void print_reading(const std::string& what, double share);

// Logs a line when a proof has gone on for another few seconds.
ProofProgress proof_printer();

}  // namespace s2nnds::program
