// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/version.h"

#include <fmt/format.h>
#include <torch/version.h>

#include <Eigen/Core>
#include <boost/version.hpp>

#include "s2nnds/core/hdf5.h"

namespace s2nnds {

std::string program_version() { return S2NNDS_VERSION; }

std::string build_type() { return S2NNDS_BUILD_TYPE; }

std::string library_versions() {
  return fmt::format("LibTorch {}, HDF5 {}, Eigen {}.{}.{}, Boost {}.{}.{}, fmt {}.{}.{}", TORCH_VERSION,
                     hdf5_version(), EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION,
                     BOOST_VERSION / 100000, BOOST_VERSION / 100 % 1000, BOOST_VERSION % 100,
                     FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100);
}

}  // namespace s2nnds
