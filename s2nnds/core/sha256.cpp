// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/sha256.h"

#include <openssl/evp.h>

#include <array>

#include "s2nnds/core/check.h"

namespace s2nnds {

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, 32> digest{};
  check(EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr) == 1,
        "SHA-256: OpenSSL cannot compute it");
  std::string text;
  for (const unsigned char byte : digest) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace s2nnds
