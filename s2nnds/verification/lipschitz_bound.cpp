// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/lipschitz_bound.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "s2nnds/problem/interval.h"
#include "s2nnds/verification/interval_matrix.h"
#include "s2nnds/verification/standard_floating_point.h"

namespace s2nnds {
namespace {

constexpr int kSquarings = 8;  // of the Gram matrix: its 256th power
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The matrix with as many rows as the smaller side: both Gram matrices have the same eigenvalues but for zeros.
IntervalMatrix gram_of(const Points& matrix) {
  const bool wide = matrix.rows() <= matrix.cols();
  IntervalMatrix a(wide ? matrix.rows() : matrix.cols(), wide ? matrix.cols() : matrix.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j < a.columns(); ++j) a(i, j) = wide ? matrix(i, j) : matrix(j, i);
  }
  return a * a.transposed();
}

double largest_magnitude(const IntervalMatrix& a) {
  double largest = 0.0;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j < a.columns(); ++j) {
      const double magnitude = a(i, j).magnitude();
      if (!(magnitude <= largest)) largest = magnitude;  // NaN stays
      if (std::isnan(largest)) return kInfinity;
    }
  }
  return largest;
}

double largest_slope(Activation activation) { return activation == Activation::silu ? 1.1 : 1.0; }

}  // namespace

// Eigenvalues of the Gram matrix G are the squared singular values, all >= 0: the largest to the power of p is at most
// the trace of G^p. After every squaring the matrix is scaled by a power of two, which is exact and whose exponents add
// up to those of the result.
double spectral_norm_bound(const Points& matrix) {
  const StandardFloatingPoint mode;
  IntervalMatrix power = gram_of(matrix);
  double exponent = 0.0;  // power * 2^exponent is the power of G, of which
  double root = 0.5;      // this power is taken at last
  for (int k = 0; k <= kSquarings; ++k) {
    if (k > 0) {
      power = power * power;
      exponent *= 2.0;
      root *= 0.5;
    }
    const double largest = largest_magnitude(power);
    if (largest == 0.0) return 0.0;
    if (!(largest < kInfinity)) return kInfinity;
    int shift = 0;
    std::frexp(largest, &shift);
    power = std::ldexp(1.0, -shift) * power;
    exponent += shift;
  }
  Interval trace;
  for (Eigen::Index i = 0; i < power.rows(); ++i) trace += power(i, i);
  // 2^(root * (log2 trace + exponent)), from above.
  const Interval bound =
      exp(Interval(root) * (log(Interval(trace.upper)) + Interval(exponent) * log(Interval(2.0))));
  return bound.is_defined() ? bound.upper : kInfinity;
}

double lipschitz_bound(const NetworkWeights& network) {
  const StandardFloatingPoint mode;
  network.check();
  Interval product(1.0);
  for (const Layer& layer : network.layers)
    product *= Interval(spectral_norm_bound(layer.weight)) * Interval(largest_slope(layer.activation));
  return product.is_defined() ? product.upper : kInfinity;
}

}  // namespace s2nnds
