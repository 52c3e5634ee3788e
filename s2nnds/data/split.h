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

// `test` and `validation` keep their order, `train` is the rest in ascending order. Throws Error when an
// index is out of range, repeated, or nothing is left.
Split split_demonstrations(std::size_t count, const std::vector<std::int64_t>& test,
                           const std::vector<std::int64_t>& validation = {});

// The demonstrations with these indices, in this order. Throws Error when an index is out of range or
// repeated.
std::vector<Demonstration> select(const std::vector<Demonstration>& all,
                                  const std::vector<std::int64_t>& indices);

}  // namespace s2nnds
