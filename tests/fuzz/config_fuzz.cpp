// SPDX-License-Identifier: BSD-3-Clause
// A configuration, and settings as --set takes them after zero bytes. Its regions are made. What is read is
// written as TOML, by itself and as the text with the settings in it; both must read back to the same.
#include <cstdlib>
#include <sstream>

#include "s2nnds/core/check.h"
#include "s2nnds/core/settings.h"
#include "s2nnds/problem/region.h"
#include "s2nnds/runs/config.h"
#include "tests/fuzz/one_line.h"

namespace {

// Empty where it cannot be read.
std::string read_again(const std::string& text) {
  try {
    return to_toml(s2nnds::parse_config(text, "again.toml"));
  } catch (const s2nnds::Error&) {
    return "";
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream parts(s2nnds::fuzz::text_of(data, size));
  std::string text;
  std::vector<std::string> settings;
  std::getline(parts, text, '\0');
  for (std::string setting; std::getline(parts, setting, '\0');) settings.push_back(setting);
  s2nnds::fuzz::expect_one_line([&] {
    const s2nnds::Config config = s2nnds::parse_config(text, "config.toml", settings);
    validate(config);
    const std::string written = to_toml(config);
    if (read_again(written) != written) std::abort();
    if (read_again(s2nnds::with_settings(text, "config.toml", settings)) != written) std::abort();
    s2nnds::make_region(config.problem.unsafe, 2);
  });
  return 0;
}
