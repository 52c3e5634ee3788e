// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/interval_matrix.h"

#include "s2nnds/core/check.h"

namespace s2nnds {

IntervalMatrix IntervalMatrix::transposed() const {
  IntervalMatrix result(columns_, rows_);
  for (Eigen::Index i = 0; i < rows_; ++i) {
    for (Eigen::Index j = 0; j < columns_; ++j) result(j, i) = (*this)(i, j);
  }
  return result;
}

IntervalMatrix operator*(const IntervalMatrix& a, const IntervalMatrix& b) {
  check(a.columns() == b.rows(), "interval matrices: found {} columns times {} rows", a.columns(), b.rows());
  IntervalMatrix result(a.rows(), b.columns());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j < b.columns(); ++j) {
      for (Eigen::Index k = 0; k < a.columns(); ++k) result(i, j) += a(i, k) * b(k, j);
    }
  }
  return result;
}

IntervalMatrix operator*(double factor, const IntervalMatrix& a) {
  IntervalMatrix result = a;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j < a.columns(); ++j) result(i, j) *= factor;
  }
  return result;
}

bool is_positive_definite(const IntervalMatrix& a) {
  const Eigen::Index n = a.rows();
  check(n == a.columns(), "definiteness: found a matrix [{}, {}], expected a square one", n, a.columns());
  IntervalMatrix s(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) s(i, j) = i == j ? a(i, i) : (a(i, j) + a(j, i)) * 0.5;
  }
  for (Eigen::Index k = 0; k < n; ++k) {
    if (!(s(k, k).lower > 0.0)) return false;
    for (Eigen::Index i = k + 1; i < n; ++i) {
      for (Eigen::Index j = i; j < n; ++j) {
        // Of a square, the intervals' product would forget the sign.
        const Interval product = i == j ? square(s(i, k)) : s(i, k) * s(j, k);
        s(i, j) -= product / s(k, k);
        s(j, i) = s(i, j);
      }
    }
  }
  return true;
}

}  // namespace s2nnds
