#pragma once

#include <string>

#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

// Verifies the record's networks by "sampled", "conformal" or "proof" and updates its certificate: the
// guarantee is the strongest one that these weights have passed. Each conformal call is a further attempt,
// which spends its share of beta. `progress` hears of the proof's levels. Throws Error when the certificate
// speaks of other weights.
void verify(const PreparedRun& setup, RunRecord& record, const std::string& method,
            const VerificationOptions& options, const ProofProgress& progress = nullptr);

}  // namespace s2nnds
