// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace s2nnds::program {

// Prints every key of a configuration, as Config::visit names them: one JSON array of objects with `key`, `default`
// and `expected` (as text), `when` (the choice that brings the key; empty: always there) and `paper`, `imitation`
// (the defaults of these profiles where they differ). Returns the exit code 0.
int keys();

}  // namespace s2nnds::program
