// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "s2nnds/runs/run_record.h"

namespace s2nnds {

// The guarantee of the record's certificate in one or two sentences.
std::string guarantee_sentence(const RunRecord& record);

// What is proved of all motions of a projected f, in a sentence or two; "" where f is not projected.
std::string stability_sentence(const RunRecord& record);

// What is guaranteed of the orientation, in a sentence or two; "" where nothing turns.
std::string orientation_sentence(const RunRecord& record);

// The same in one paragraph, with what was checked and how: conditions, numbers of samples, margins. Lengths
// and velocities are in the unit of the data too.
std::string guarantee_statement(const RunRecord& record);

// "certified from 0.3 to 1.8 times the demonstrated speed (up to 210 mm/s)"; "" where no range was looked for.
std::string certified_speeds_in_words(const RunRecord& record);

// What a conformal figure is printed with: which attempts its beta is split over.
inline constexpr std::string_view kAttemptsCounted =
    "Attempts are counted in this run file: a retraining, another seed or a copy of the file begins anew, "
    "and beta is not split over those.";

}  // namespace s2nnds
