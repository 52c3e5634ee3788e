// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/runs/run_record.h"

namespace s2nnds::program {

// The text broken at words; every line starts with two blanks.
std::string paragraph(const std::string& text);
// "  name  text", of one line of a screen.
std::string row(const char* name, const std::string& text);

// Where the goal lies, how far every demonstration ends from it, and what one normalised unit is: one line.
std::string frame_line(const RunRecord& record);

// What a run reached, on one screen: guarantee, goal, sets, errors, safe area, disturbance margin, time. `path` is
// where it is stored. At most 24 lines.
std::string first_screen(const RunRecord& record, const std::string& path);

// The verdicts on all conditions, one table a method.
std::string condition_tables(const RunRecord& record);

// All else that is worth reading: statement, conditions, configuration, the last rounds, hashes, versions.
std::string details(const RunRecord& record);

}  // namespace s2nnds::program
