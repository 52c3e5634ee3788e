// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/split.h"

#include <algorithm>

#include "s2nnds/core/check.h"

namespace s2nnds {

void check_indices(std::size_t count, const std::vector<std::int64_t>& indices) {
  std::vector<bool> seen(count, false);
  for (const std::int64_t index : indices) {
    check(index >= 0 && index < static_cast<std::int64_t>(count),
          "demonstrations: found index {}; expected 0 to {}, counted from 0 (data.use, data.test, "
          "data.validation)",
          index, static_cast<std::int64_t>(count) - 1);
    check(!seen[static_cast<std::size_t>(index)], "demonstrations: found index {} twice; expected it once",
          index);
    seen[static_cast<std::size_t>(index)] = true;
  }
}

namespace {

// The last fifth of the demonstrations that do not validate.
std::vector<std::int64_t> test_by_share(std::size_t count, const std::vector<std::int64_t>& validation) {
  std::vector<std::int64_t> rest;
  for (std::int64_t k = 0; k < static_cast<std::int64_t>(count); ++k)
    if (std::find(validation.begin(), validation.end(), k) == validation.end()) rest.push_back(k);
  const auto held_out = static_cast<std::ptrdiff_t>(rest.size() < 4 ? 0 : (rest.size() + 2) / 5);
  return {rest.end() - held_out, rest.end()};
}

}  // namespace

Split split_demonstrations(std::size_t count, const std::vector<std::int64_t>& test,
                           const std::vector<std::int64_t>& validation) {
  if (test == std::vector<std::int64_t>{kTestByShare})
    return split_demonstrations(count, test_by_share(count, validation), validation);
  std::vector<std::int64_t> held_out = test;
  held_out.insert(held_out.end(), validation.begin(), validation.end());
  check_indices(count, held_out);
  Split split{{}, test, validation};
  for (std::int64_t k = 0; k < static_cast<std::int64_t>(count); ++k) {
    if (std::find(held_out.begin(), held_out.end(), k) == held_out.end()) split.train.push_back(k);
  }
  check(!split.train.empty(),
        "data.test, data.validation: found {} of {} demonstrations held out; expected at least 1 left to "
        "train on",
        held_out.size(), count);
  return split;
}

}  // namespace s2nnds
