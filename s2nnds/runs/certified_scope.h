// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/runs/prepared_run.h"

namespace s2nnds {

// All that a certificate depends on, as TOML: the weights' hash, the frame, the workspace and the part of it that holds
// the safe set (normalised), the band, both sets with nothing left to find out, the hashes of the files that they
// name, the execution model, if there is one, and where poses move the orientation law: psi's hash, its
// rate, the largest initial error and the goal's orientation. The networks and the law are the record's. Two runs with the same text have the same conditions.
std::string certified_scope(const PreparedRun& setup, const RunRecord& record);

// Binds the certificate to the run: its scope, and a seal over both and all its figures.
void seal_certificate(const PreparedRun& setup, RunRecord& record);

// Whether the certificate is of these networks and this problem, and is as it was sealed.
bool is_intact(const PreparedRun& setup, const RunRecord& record);

// Throws Error starting with `path` when the run's certificate claims or found anything, but not of the networks, the
// problem and the data that the run holds, or when a figure of it was changed. A seal is no signature: it notices what
// was edited or mixed up, not a forger.
void check_certificate(const RunRecord& record, const std::string& path);

// load_run and check_certificate.
RunRecord load_certified_run(const std::string& path);

}  // namespace s2nnds
