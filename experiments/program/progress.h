#pragma once

#include "s2nnds/runs/run_record.h"
#include "s2nnds/training/trainer.h"

namespace s2nnds::program {

// One line a round on stderr: losses, counterexamples by condition, time. A terminal gets a header and
// columns, a pipe plain "key=value" lines.
void print_round(const RoundSummary& row);

// What a run reached, for people, on stdout.
void print_summary(const RunRecord& record, const std::string& path);

}  // namespace s2nnds::program
