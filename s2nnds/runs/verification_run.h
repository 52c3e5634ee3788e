// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

// Checks the record's networks and updates its certificate: verdicts, guarantee and statement. Earlier
// verdicts of other methods stay. Each conformal call is a further attempt, which spends its share of beta.
// `progress` hears of the proof's levels; `covers` receives the boxes that prove each condition, where all are proved.
// Throws Error when the certificate speaks of other weights.
void verify(const PreparedRun& setup, RunRecord& record, Method method, const VerificationOptions& options,
            const ProofProgress& progress = nullptr, ProofCovers* covers = nullptr);

// After a proof that reached `invariant`: finds the range of speed factors that is certified under the run's execution
// model, and updates the certificate. Throws Error without an execution model or that guarantee.
void find_certified_speeds(const PreparedRun& setup, RunRecord& record);

// What ends a training: verify() by samples, by the configured method, and conformally where a proof is asked for and does
// not succeed.
void verify_as_configured(const PreparedRun& setup, RunRecord& record,
                          const ProofProgress& progress = nullptr);

}  // namespace s2nnds
