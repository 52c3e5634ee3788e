#pragma once

#include <string>

#include "s2nnds/runs/run_record.h"

namespace s2nnds {

// What the record's certificate guarantees, in words: one paragraph, with lengths and velocities in the unit
// of the data.
std::string guarantee_statement(const RunRecord& record);

}  // namespace s2nnds
