// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace s2nnds {

// The text of deployment/pt2_writer.py, built into the library: it needs no installation to find its script.
extern const char* const pt2_writer_source;

}  // namespace s2nnds
