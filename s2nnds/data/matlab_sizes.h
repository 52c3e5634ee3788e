// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace s2nnds {

// Holds every size that a file of MATLAB 5 to 7 (`bytes`) tells against the bytes that are there: lengths, sides of
// arrays, numbers of cells and fields, also of what is compressed, whose checksums it compares. Other versions
// are refused. libmatio believes
// them, takes the memory, and reads on behind the end of the file. Throws Error that starts with `path` and says
// at its end what was `expected`. The layout is that of "MAT-File Format" (The MathWorks).
void check_matlab_sizes(std::string_view bytes, const std::string& path, const std::string& expected);

}  // namespace s2nnds
