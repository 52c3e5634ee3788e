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

  Position lower() const { return node_lower(0); }  // the box around all items [n]
  Position upper() const { return node_upper(0); }  // its other corner [n]

  Position item_lower(std::size_t k) const { return item_lower_.row(static_cast<Eigen::Index>(k)); }  // [n]
  Position item_upper(std::size_t k) const { return item_upper_.row(static_cast<Eigen::Index>(k)); }  // [n]

  // Calls item(k) for every item k for which `bound`, of the two corners of its box and of each node around
  // it, is at most the limit; item() returns the limit from then on, which starts at infinity. Near nodes go
  // first.
  template <typename Bound, typename Item>
  void search(const Bound& bound, const Item& item) const;
  // Calls item(k) for every item k in a node whose corners `meets` wants, until one returns false; false then.
  template <typename Meets, typename Item>
  bool visit(const Meets& meets, const Item& item) const;

 private:
  struct Node {
    std::size_t first = 0, last = 0;  // its items in `order_`, if it has no children
    std::size_t child = 0;            // the first of two; 0: none
  };
  // A node that a search has yet to look at, and its bound.
  struct Open {
    double least;
    std::size_t node;
  };
  // Every step down halves the items and leaves one node aside, so that no more can be open at a time.
  static constexpr std::size_t most_open = 66;

  void build(std::size_t node, std::size_t first, std::size_t last);
  Position node_lower(std::size_t node) const { return corner(2 * node); }
  Position node_upper(std::size_t node) const { return corner(2 * node + 1); }
  Position corner(std::size_t k) const {
    const Eigen::Index n = item_lower_.cols();
    return Eigen::Map<const Vector>(corners_.data() + k * static_cast<std::size_t>(n), n);
  }

  Points item_lower_, item_upper_;  // [N, n]
  std::vector<Node> nodes_;
  std::vector<double> corners_;  // the lower [n], then the upper one [n] of every node
  std::vector<std::size_t> order_;
};

template <typename Bound, typename Item>
void BoxTree::search(const Bound& bound, const Item& item) const {
  double limit = std::numeric_limits<double>::infinity();
  std::array<Open, most_open> open;
  std::size_t count = 0;
  open[count++] = {bound(node_lower(0), node_upper(0)), 0};
  while (count > 0) {
    const auto [least, index] = open[--count];
    if (!(least <= limit)) continue;
    const Node& node = nodes_[index];
    if (node.child == 0) {
      for (std::size_t at = node.first; at < node.last; ++at) {
        const std::size_t k = order_[at];
        if (bound(item_lower(k), item_upper(k)) <= limit) limit = item(k);
      }
      continue;
    }
    std::size_t nearer = node.child, farther = node.child + 1;
    double to_nearer = bound(node_lower(nearer), node_upper(nearer));
    double to_farther = bound(node_lower(farther), node_upper(farther));
    if (to_farther < to_nearer) {
      std::swap(nearer, farther);
      std::swap(to_nearer, to_farther);
    }
    open[count++] = {to_farther, farther};
    open[count++] = {to_nearer, nearer};
  }
}

template <typename Meets, typename Item>
bool BoxTree::visit(const Meets& meets, const Item& item) const {
  std::array<std::size_t, most_open> open;
  std::size_t count = 0;
  open[count++] = 0;
  while (count > 0) {
    const std::size_t index = open[--count];
    if (!meets(node_lower(index), node_upper(index))) continue;
    const Node& node = nodes_[index];
    if (node.child == 0) {
      for (std::size_t k = node.first; k < node.last; ++k) {
        if (!item(order_[k])) return false;
      }
      continue;
    }
    open[count++] = node.child;
    open[count++] = node.child + 1;
  }
  return true;
}

}  // namespace s2nnds
