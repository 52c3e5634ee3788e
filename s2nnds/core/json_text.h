// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace s2nnds {

// JSON as text, on one line where `indent` is negative. Bytes of files that are not UTF-8 become U+FFFD; the library
// would throw.
template <typename Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace s2nnds
