// SPDX-License-Identifier: BSD-3-Clause
// A configuration, and settings as --set takes them after zero bytes. What is read is written as TOML, which
// must read back to the same; its regions are made.
#include <cstdlib>
#include <sstream>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/region.h"
#include "s2nnds/runs/config.h"
#include "tests/fuzz/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream parts(s2nnds::fuzz::text_of(data, size));
  std::string text;
  std::vector<std::string> settings;
  std::getline(parts, text, '\0');
  for (std::string setting; std::getline(parts, setting, '\0');) settings.push_back(setting);
  s2nnds::fuzz::expect_one_line([&] {
    s2nnds::Config config = s2nnds::parse_config(text, "config.toml", settings);
    const std::string written = to_toml(config);
    s2nnds::Config again = s2nnds::parse_config(written, "written.toml");
    if (to_toml(again) != written) std::abort();
    s2nnds::make_region(config.problem.unsafe, 2);
  });
  return 0;
}
