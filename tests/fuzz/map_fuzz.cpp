// SPDX-License-Identifier: BSD-3-Clause
// A map: its YAML, and after a zero byte its image, which the YAML must call map.pgm; the region of its cells.
#include <algorithm>
#include <map>

#include "s2nnds/problem/occupancy_region.h"
#include "tests/fuzz/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes = s2nnds::fuzz::text_of(data, size);
  const std::size_t end = std::min(bytes.find('\0'), bytes.size());
  s2nnds::RegionFiles files(std::map<std::string, std::string>{
      {"map.yaml", bytes.substr(0, end)}, {"map.pgm", bytes.substr(std::min(end + 1, bytes.size()))}});
  for (const bool unknown_is_occupied : {false, true}) {
    s2nnds::fuzz::expect_one_line([&] {
      const s2nnds::OccupancyMap map = s2nnds::read_occupancy_map("map.yaml", files);
      const s2nnds::RegionPtr region = s2nnds::occupied_cells(map, unknown_is_occupied, "map");
      region->level(s2nnds::Points{{0.2, 0.2}});
      region->classify({.lower = s2nnds::Vector{{0.1, 0.1}}, .upper = s2nnds::Vector{{0.2, 0.2}}});
    });
  }
  return 0;
}
