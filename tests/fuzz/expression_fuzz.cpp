// SPDX-License-Identifier: BSD-3-Clause
// An expression in two variables: its text, a few values, an enclosure.
#include "s2nnds/problem/expression.h"
#include "tests/fuzz/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  s2nnds::fuzz::expect_one_line([&] {
    const s2nnds::ExpressionTree tree = s2nnds::parse_expression(s2nnds::fuzz::text_of(data, size), 2);
    const s2nnds::Points corners{{-1.25, -1.0}, {0.0, 0.0}, {1.25, 1.0}};
    tree.value(corners);
    tree.enclosure({.lower = corners.row(0).transpose(), .upper = corners.row(2).transpose()});
  });
  return 0;
}
