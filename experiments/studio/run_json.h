// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "s2nnds/runs/run_record.h"

namespace s2nnds::studio {

// All that the page shows of a run: frame, networks with every weight as it is, demonstrations, sets, counterexamples,
// history, certificate and statement, in the data's unit and frame (networks and history: normalised). Arrays are
// {"shape", "f64" or "f32"}: little-endian numbers in base64. Throws Error as prepare(record) does.
nlohmann::ordered_json run_json(const RunRecord& record);

}  // namespace s2nnds::studio
