// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace s2nnds::fuzz {

// Runs `read` and holds it to the rule for bad input: it returns, or throws Error with one line of printable
// text, and nobody prints anything, libraries included. Anything else aborts, which the fuzzer reports.
void expect_one_line(const std::function<void()>& read);

// The input as text.
inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// Writes the input to a file of this process, whose path it returns; the next call replaces it.
std::string file_of(const std::uint8_t* data, std::size_t size, const std::string& ending);

}  // namespace s2nnds::fuzz
