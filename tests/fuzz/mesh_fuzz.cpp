// SPDX-License-Identifier: BSD-3-Clause
// A mesh in each format, the solid within it, and whether a point is in that.
#include "s2nnds/problem/mesh_file.h"
#include "tests/fuzz/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes = s2nnds::fuzz::text_of(data, size);
  for (const char* const name : {"mesh.stl", "mesh.obj"}) {
    s2nnds::fuzz::expect_one_line([&] {
      const s2nnds::RegionPtr region = s2nnds::solid(s2nnds::read_mesh(bytes, name), name);
      region->level(s2nnds::Points{{0.2, 0.2, 0.2}});
      region->classify({.lower = s2nnds::Vector{{0.1, 0.1, 0.1}}, .upper = s2nnds::Vector{{0.2, 0.2, 0.2}}});
    });
  }
  return 0;
}
