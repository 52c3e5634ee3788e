// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/split.h"

#include <algorithm>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// Throws Error unless all indices are below `count` and differ from one another.
void check_indices(std::size_t count, const std::vector<std::int64_t>& indices) {
  std::vector<bool> seen(count, false);
  for (const std::int64_t index : indices) {
    check(index >= 0 && index < static_cast<std::int64_t>(count),
          "demonstrations: found index {}; expected 0 to {}, counted from 0", index,
          static_cast<std::int64_t>(count) - 1);
    check(!seen[static_cast<std::size_t>(index)], "demonstrations: found index {} twice; expected it once",
          index);
    seen[static_cast<std::size_t>(index)] = true;
  }
}

}  // namespace

Split split_demonstrations(std::size_t count, const std::vector<std::int64_t>& test,
                           const std::vector<std::int64_t>& validation) {
  std::vector<std::int64_t> held_out = test;
  held_out.insert(held_out.end(), validation.begin(), validation.end());
  check_indices(count, held_out);
  Split split{{}, test, validation};
  for (std::int64_t k = 0; k < static_cast<std::int64_t>(count); ++k) {
    if (std::find(held_out.begin(), held_out.end(), k) == held_out.end()) split.train.push_back(k);
  }
  check(!split.train.empty(),
        "split: found {} of {} demonstrations held out; expected at least 1 left to train on",
        held_out.size(), count);
  return split;
}

std::vector<Demonstration> select(const std::vector<Demonstration>& all,
                                  const std::vector<std::int64_t>& indices) {
  check_indices(all.size(), indices);
  std::vector<Demonstration> chosen;
  chosen.reserve(indices.size());
  for (const std::int64_t index : indices) chosen.push_back(all[static_cast<std::size_t>(index)]);
  return chosen;
}

}  // namespace s2nnds
