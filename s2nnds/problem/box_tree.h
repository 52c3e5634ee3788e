// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "s2nnds/problem/simplex.h"

namespace s2nnds {

// A bounding volume hierarchy: a binary tree of boxes over many small boxes, the items, so that a search looks
// at few of them. Constant once built: searches may run at the same time.
class BoxTree {
 public:
  // The items' corners [N, n], finite, N >= 1.
  BoxTree(Points lower, Points upper);

  const Position& lower() const { return nodes_.front().lower; }  // the box around all items [n]
  const Position& upper() const { return nodes_.front().upper; }  // its other corner [n]

  Position item_lower(std::size_t k) const { return item_lower_.row(static_cast<Eigen::Index>(k)); }  // [n]
  Position item_upper(std::size_t k) const { return item_upper_.row(static_cast<Eigen::Index>(k)); }  // [n]

  // Calls item(k) for every item k in a node for which `bound` (of its two corners) is at most the limit;
  // item() returns the limit from then on, which starts at infinity. Near nodes go first.
  template <typename Bound, typename Item>
  void search(const Bound& bound, const Item& item) const;
  // Calls item(k) for every item k in a node whose corners `meets` wants, until one returns false; false then.
  template <typename Meets, typename Item>
  bool visit(const Meets& meets, const Item& item) const;

 private:
  struct Node {
    Position lower, upper;            // around its items
    std::size_t first = 0, last = 0;  // its items in `order_`, if it has no children
    std::size_t child = 0;            // the first of two; 0: none
  };
  void build(std::size_t node, std::size_t first, std::size_t last);

  Points item_lower_, item_upper_;  // [N, n]
  std::vector<Node> nodes_;
  std::vector<std::size_t> order_;
};

template <typename Bound, typename Item>
void BoxTree::search(const Bound& bound, const Item& item) const {
  double limit = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, std::size_t>> open{{bound(nodes_[0].lower, nodes_[0].upper), 0}};
  while (!open.empty()) {
    const auto [least, index] = open.back();
    open.pop_back();
    if (!(least <= limit)) continue;
    const Node& node = nodes_[index];
    if (node.child == 0) {
      for (std::size_t k = node.first; k < node.last; ++k) limit = item(order_[k]);
      continue;
    }
    std::array<std::pair<double, std::size_t>, 2> children;
    for (std::size_t k = 0; k < 2; ++k) {
      const Node& child = nodes_[node.child + k];
      children[k] = {bound(child.lower, child.upper), node.child + k};
    }
    if (children[0].first < children[1].first) std::swap(children[0], children[1]);
    open.insert(open.end(), children.begin(), children.end());
  }
}

template <typename Meets, typename Item>
bool BoxTree::visit(const Meets& meets, const Item& item) const {
  std::vector<std::size_t> open{0};
  while (!open.empty()) {
    const Node& node = nodes_[open.back()];
    open.pop_back();
    if (!meets(node.lower, node.upper)) continue;
    if (node.child == 0) {
      for (std::size_t k = node.first; k < node.last; ++k) {
        if (!item(order_[k])) return false;
      }
      continue;
    }
    open.push_back(node.child);
    open.push_back(node.child + 1);
  }
  return true;
}

}  // namespace s2nnds
