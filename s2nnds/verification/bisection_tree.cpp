// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/bisection_tree.h"

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

using Levels = std::vector<std::vector<std::int8_t>>;

class BitWriter {
 public:
  explicit BitWriter(const Levels& levels) : levels_(levels) {
    for (const std::vector<std::int8_t>& level :
         levels) {  // where the parts of each box begin in the next level
      std::vector<std::size_t> first;
      std::size_t next = 0;
      for (const std::int8_t cuts : level) {
        first.push_back(next);
        if (cuts > 0) next += std::size_t{1} << cuts;
      }
      first_part_.push_back(std::move(first));
      parts_.push_back(next);
    }
  }

  std::vector<std::uint8_t> write() {
    for (std::size_t k = 0; k < levels_.size(); ++k) {
      const std::size_t found = k + 1 < levels_.size() ? levels_[k + 1].size() : 0;
      check(parts_[k] == found, "bisection tree: found {} boxes after {} bisections, expected {}", found,
            k + 1, parts_[k]);
    }
    for (std::size_t i = 0; !levels_.empty() && i < levels_.front().size(); ++i) box(0, i);
    return bytes_;
  }

 private:
  void box(std::size_t level, std::size_t i) {
    const std::int8_t cuts = levels_[level][i];
    if (cuts > 0) {
      parts(level + 1, first_part_[level][i], cuts);
    } else {
      bit(false);
      bit(cuts == BisectionTree::shown);
    }
  }
  void parts(std::size_t level, std::size_t first, int cuts) {
    if (cuts == 0) return box(level, first);
    bit(true);
    parts(level, first, cuts - 1);
    parts(level, first + (std::size_t{1} << (cuts - 1)), cuts - 1);
  }
  void bit(bool set) {
    if (count_ % 8 == 0) bytes_.push_back(0);
    if (set) bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | 0x80U >> count_ % 8);
    ++count_;
  }

  const Levels& levels_;
  std::vector<std::vector<std::size_t>> first_part_;
  std::vector<std::size_t> parts_;
  std::vector<std::uint8_t> bytes_;
  std::size_t count_ = 0;
};

}  // namespace

std::vector<std::uint8_t> BisectionTree::bytes() const { return BitWriter(levels_).write(); }

}  // namespace s2nnds
