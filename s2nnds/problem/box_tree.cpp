// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/box_tree.h"

#include <algorithm>
#include <numeric>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr std::size_t kMostItems = 4;  // of a node without children

}  // namespace

BoxTree::BoxTree(Points lower, Points upper) : item_lower_(std::move(lower)), item_upper_(std::move(upper)) {
  check(item_lower_.rows() > 0 && item_lower_.cols() <= most_coordinates && item_lower_.allFinite() &&
            item_upper_.allFinite(),
        "box tree: [{}, {}] coordinates, expected finite ones of at least one item in at most {} dimensions",
        item_lower_.rows(), item_lower_.cols(), most_coordinates);
  order_.resize(static_cast<std::size_t>(item_lower_.rows()));
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  nodes_.reserve(order_.size());
  nodes_.emplace_back();
  build(0, 0, order_.size());
  corners_.shrink_to_fit();
}

// Halves the items at the median of their centres along the axis in which these spread the most.
void BoxTree::build(std::size_t node, std::size_t first, std::size_t last) {
  Position low = item_lower(order_[first]), high = item_upper(order_[first]);
  Position least = low + high, greatest = low + high;  // of twice the centres
  for (std::size_t k = first; k < last; ++k) {
    const Position item_low = item_lower(order_[k]), item_high = item_upper(order_[k]);
    low = low.cwiseMin(item_low);
    high = high.cwiseMax(item_high);
    least = least.cwiseMin(item_low + item_high);
    greatest = greatest.cwiseMax(item_low + item_high);
  }
  const auto n = static_cast<std::size_t>(low.size());
  corners_.resize(std::max(corners_.size(), 2 * nodes_.size() * n));
  std::copy_n(low.data(), n, corners_.begin() + static_cast<std::ptrdiff_t>(2 * node * n));
  std::copy_n(high.data(), n, corners_.begin() + static_cast<std::ptrdiff_t>((2 * node + 1) * n));
  nodes_[node].first = first;
  nodes_[node].last = last;
  if (last - first <= kMostItems) return;
  Eigen::Index axis = 0;
  (greatest - least).maxCoeff(&axis);
  const auto center = [&](std::size_t item) {
    return item_lower_(static_cast<Eigen::Index>(item), axis) +
           item_upper_(static_cast<Eigen::Index>(item), axis);
  };
  const std::size_t middle = first + (last - first) / 2;
  const auto at = [&](std::size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
  std::nth_element(at(first), at(middle), at(last),
                   [&](std::size_t a, std::size_t b) { return center(a) < center(b); });
  const std::size_t child = nodes_.size();
  nodes_[node].child = child;
  nodes_.resize(child + 2);
  build(child, first, middle);
  build(child + 1, middle, last);
}

}  // namespace s2nnds
