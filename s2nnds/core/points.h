// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace s2nnds {

// N points (or velocities) of dimension n, one a row: [N, n]. Row-major, so that it shares the layout of
// tensors, of HDF5 datasets and of numpy arrays.
using Points = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
// A column of numbers: one point [n], or one number for each of N points [N].
using Vector = Eigen::VectorXd;

}  // namespace s2nnds
