// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>

#include "s2nnds/core/random.h"
#include "s2nnds/networks/evaluator.h"
#include "s2nnds/problem/box.h"

namespace s2nnds {

// Draws i.i.d. uniform points of the band |B(x)| <= band within a box. The band is often less than a
// hundredth of the workspace; so boxes that Taylor models of B prove to be off it are left out, and the rest
// is sampled by rejection.
class BandSampler {
 public:
  // Throws Error unless `within` is finite and of B's dimension.
  BandSampler(const NetworkWeights& B, const Box& within, double band);

  // [count, n]. Fewer rows, perhaps none, when the band is too thin even for this: more than a thousand draws
  // a point, or so few points to begin with that it would take twice as many. A B without a finite value
  // counts as within the band.
  Points sample(std::int64_t count, RandomStream& random) const;
  // The volume of what is sampled by rejection, at least that of the band.
  double cover_volume() const;

 private:
  Points draw(std::int64_t count, RandomStream& random) const;
  // Those that B in single precision, less its rounding errors, does not show to be off the band.
  Points not_surely_off(const Points& x) const;

  Evaluator barrier_;
  BasicEvaluator<float> quick_barrier_;
  // |B in single - B in double precision| at most
  double quick_error_ = std::numeric_limits<double>::infinity();
  double band_;
  Points lower_;  // [M, n] of the cover's boxes, which all have one size
  Vector side_;   // [n]
};

}  // namespace s2nnds
