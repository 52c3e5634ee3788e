// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "s2nnds/core/points.h"
#include "s2nnds/problem/region_files.h"

namespace s2nnds {

// What is known of one cell of a map.
enum class Cell : std::uint8_t { free, occupied, unknown };

// An occupancy grid in the plane, as ROS keeps it.
struct OccupancyMap {
  Eigen::Matrix<Cell, Eigen::Dynamic, Eigen::Dynamic>
      cells;                // [width, height]: along the map's x, then its y
  double resolution = 0.0;  // side of a cell, > 0
  Vector origin;            // [2], of the corner of the cell (0, 0)
  double yaw = 0.0;         // radians, of the map's x axis from the first axis
};

// Reads a map of ROS's map_server: YAML with image (PGM, text or binary, 8 bits), resolution, origin (x, y,
// yaw), negate, occupied_thresh and free_thresh, mode trinary or scale.
// `name` is that of the YAML file in `files`; the image counts from its folder. Throws Error where a file is not
// whole or a value is missing or not as said here.
OccupancyMap read_occupancy_map(const std::string& name, RegionFiles& files);

}  // namespace s2nnds
