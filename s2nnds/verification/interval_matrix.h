// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/problem/interval.h"

namespace s2nnds {

// A small dense matrix of intervals: all real matrices whose entries lie in them.
class IntervalMatrix {
 public:
  IntervalMatrix(Eigen::Index rows, Eigen::Index columns)
      : rows_(rows), columns_(columns), entries_(rows * columns) {}

  Eigen::Index rows() const { return rows_; }
  Eigen::Index columns() const { return columns_; }
  Interval& operator()(Eigen::Index i, Eigen::Index j) { return entries_[i * columns_ + j]; }
  const Interval& operator()(Eigen::Index i, Eigen::Index j) const { return entries_[i * columns_ + j]; }
  IntervalMatrix transposed() const;

 private:
  Eigen::Index rows_, columns_;
  std::vector<Interval> entries_;
};

IntervalMatrix operator*(const IntervalMatrix& a, const IntervalMatrix& b);
IntervalMatrix operator*(double factor, const IntervalMatrix& a);

// Whether x' A x > 0 for every x != 0 and every real A in the matrix [n, n]: the pivots of the symmetric
// part's elimination, in intervals, are all positive. False if that cannot be shown.
bool is_positive_definite(const IntervalMatrix& a);

}  // namespace s2nnds
