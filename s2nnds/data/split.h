// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// Train, test and validation by whole demonstrations, as indices from 0.
struct Split {
  std::vector<std::int64_t> train;            // what networks are trained on
  std::vector<std::int64_t> test;             // held out
  std::vector<std::int64_t> validation = {};  // held out, for choosing among runs
};

// In place of the indices to test: a share of them (see split_demonstrations).
inline constexpr std::int64_t kTestByShare = -1;

// `test` = {kTestByShare} takes the last fifth (rounded) of those that do not validate, and none of fewer than
// four. `test` and `validation` keep their order, `train` is the rest in ascending order. Throws Error when an
// index is out of range, repeated, or nothing is left.
Split split_demonstrations(std::size_t count, const std::vector<std::int64_t>& test,
                           const std::vector<std::int64_t>& validation = {});

// Throws Error unless all indices are below `count` and differ from one another.
void check_indices(std::size_t count, const std::vector<std::int64_t>& indices);

// Those of `all` (demonstrations, recordings) with these indices, in this order. Throws Error as
// check_indices.
template <typename T>
std::vector<T> select(const std::vector<T>& all, const std::vector<std::int64_t>& indices) {
  check_indices(all.size(), indices);
  std::vector<T> chosen;
  chosen.reserve(indices.size());
  for (const std::int64_t index : indices) chosen.push_back(all[static_cast<std::size_t>(index)]);
  return chosen;
}

}  // namespace s2nnds
