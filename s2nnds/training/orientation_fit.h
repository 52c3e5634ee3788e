// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/data/demonstration.h"
#include "s2nnds/data/frame.h"
#include "s2nnds/networks/orientation_law.h"
#include "s2nnds/problem/box.h"

namespace s2nnds {

// How orientations follow positions, where data.state is "pose".
struct OrientationOptions {
  std::int64_t features = 128;  // neurons of the hidden layer of psi, 1 to 4,096
  // k, 1/s: how fast an orientation error falls, as exp(-k t). 0: five over the mean duration of the training
  // demonstrations, so that less than a hundredth is left after it.
  double rate = 0;
  // Degrees in [0, 180): the largest orientation error of a start that the certificate speaks of, against the
  // orientation psi that belongs to its position. 0: the largest along the training demonstrations, and 10 more.
  double initial_error = 0;

  void visit(FieldVisitor& v);  // names each field once
};

// Fits psi to r = log(q_goal^-1 q) along normalised demonstrations: tanh features drawn from the stream (seed,
// "orientation") and their weights by least squares, each demonstration counting alike. Beside it stands, weighed by
// lambda, the mean of |psi|^2 over points drawn from {B <= 0}, so that psi stays small where nothing was shown. Among
// 10^-6 ... 10 the lambda is taken with the least error on demonstrations left out one by one (of a single one 10^-3),
// or the next larger ones until |psi| + initial_error < 0.97 pi at the drawn points.
// Throws Error without demonstrations or orientations.
OrientationLaw fit_orientation(const std::vector<Demonstration>& demonstrations, const Frame& frame,
                               const NetworkWeights& barrier, const Box& workspace,
                               const OrientationOptions& options, std::uint64_t seed);

}  // namespace s2nnds
