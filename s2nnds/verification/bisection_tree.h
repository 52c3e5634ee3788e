// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace s2nnds {

// How branch and bound took boxes apart, level by level as it went.
class BisectionTree {
 public:
  // What became of a box.
  static constexpr std::int8_t shown = 0;      // the statement was shown on it
  static constexpr std::int8_t excluded = -1;  // the statement asks nothing of it
  // The boxes of the next level in their order, from the start's on: `shown`, `excluded`, or how often the box was
  // bisected (> 0). Its 2^cuts parts are the next level's boxes, in the order of the boxes that they are parts of.
  void add_level(std::vector<std::int8_t> boxes) { levels_.push_back(std::move(boxes)); }

  // The start's boxes one after the other, depth first: 1 for a bisection, behind it the lower half, then the upper one;
  // 00 for a box that is excluded, 01 for one on which the statement was shown. The first bit is the highest of the first
  // byte, and zeros fill the last byte. Throws Error where the levels do not fit together.
  std::vector<std::uint8_t> bytes() const;

 private:
  std::vector<std::vector<std::int8_t>> levels_;
};

}  // namespace s2nnds
