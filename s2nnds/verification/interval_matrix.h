// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/core/points.h"
#include "s2nnds/problem/interval.h"

namespace s2nnds {

// A small dense matrix of intervals: all real matrices whose entries lie in them.
class IntervalMatrix {
 public:
  // Every entry is the interval [0, 0].
  IntervalMatrix(Eigen::Index rows, Eigen::Index columns)
      : rows_(rows), columns_(columns), entries_(rows * columns) {}

  Eigen::Index rows() const { return rows_; }        // number of rows, >= 0
  Eigen::Index columns() const { return columns_; }  // number of columns, >= 0
  // The entry in row i and column j, from 0; not checked.
  Interval& operator()(Eigen::Index i, Eigen::Index j) { return entries_[i * columns_ + j]; }
  // The entry in row i and column j, from 0; not checked.
  const Interval& operator()(Eigen::Index i, Eigen::Index j) const { return entries_[i * columns_ + j]; }
  IntervalMatrix transposed() const;  // [columns, rows]

 private:
  Eigen::Index rows_, columns_;
  std::vector<Interval> entries_;
};

// Encloses all products of a matrix of `a` and one of `b`. Throws Error unless a's columns are b's rows.
IntervalMatrix operator*(const IntervalMatrix& a, const IntervalMatrix& b);

// Encloses `factor` times every matrix of `a`.
IntervalMatrix operator*(double factor, const IntervalMatrix& a);

// Whether x' A x > 0 for every x != 0 and every real A in the matrix [n, n]: the pivots of the symmetric
// part's elimination, in intervals, are all positive. False if that cannot be shown. Throws Error unless the
// matrix is square.
bool is_positive_definite(const IntervalMatrix& a);

}  // namespace s2nnds
