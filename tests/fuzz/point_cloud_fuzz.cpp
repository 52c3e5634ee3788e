// SPDX-License-Identifier: BSD-3-Clause
// A point cloud in each format, in the plane and in space.
#include "s2nnds/problem/point_cloud_file.h"
#include "tests/fuzz/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes = s2nnds::fuzz::text_of(data, size);
  for (const char* const name : {"cloud.csv", "cloud.ply", "cloud.pcd", "cloud.npy"}) {
    for (const int dimension : {2, 3}) {
      s2nnds::fuzz::expect_one_line([&] { s2nnds::read_point_cloud(bytes, name, dimension); });
    }
  }
  return 0;
}
