// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace s2nnds {

// SHA-256 of the bytes, 64 hexadecimal digits. Throws Error when OpenSSL cannot compute it.
std::string sha256(std::string_view bytes);

}  // namespace s2nnds
