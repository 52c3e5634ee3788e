#pragma once

#include "s2nnds/runs/run_record.h"
#include "s2nnds/training/trainer.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds::program {

// One line a round on stderr: losses, counterexamples by condition, time. A terminal gets a header and
// columns, a pipe plain "key=value" lines.
void print_round(const RoundSummary& row);

// Prints a line on stderr when a proof has gone on for another few seconds.
ProofProgress proof_printer();

// What a run reached, for people, on stdout.
void print_summary(const RunRecord& record, const std::string& path);

}  // namespace s2nnds::program
