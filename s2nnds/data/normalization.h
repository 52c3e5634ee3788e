#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// Normalised position = position / position_scale; normalised velocity = velocity / velocity_scale.
// Normalised time is seconds * velocity_scale / position_scale, so that d(position)/d(time) = velocity holds
// in normalised units.
struct Normalization {
  std::string kind = "max_abs";
  double position_scale = 1.0;
  double velocity_scale = 1.0;

  // Seconds per unit of normalised time.
  double time_scale() const { return position_scale / velocity_scale; }
};

// Scales from all demonstrations: max_abs takes the largest absolute coordinate, max_norm the largest
// Euclidean norm. Throws Error when there is no motion (a scale of zero).
Normalization find_normalization(const std::string& kind, const std::vector<Demonstration>& demonstrations);

// Position, velocity and time in normalised units.
std::vector<Demonstration> normalize(const std::vector<Demonstration>& demonstrations,
                                     const Normalization& scales);

// Train, test and validation by whole demonstrations; `test` and `validation` keep their order, `train` is
// the rest in ascending order. Throws Error when an index is out of range, repeated, or nothing is left.
struct Split {
  std::vector<std::int64_t> train;
  std::vector<std::int64_t> test;
  std::vector<std::int64_t> validation = {};  // for choosing among runs
};
Split split_demonstrations(std::size_t count, const std::vector<std::int64_t>& test,
                           const std::vector<std::int64_t>& validation = {});

// The demonstrations with these indices, in this order. Throws Error when an index is out of range or
// repeated.
std::vector<Demonstration> select(const std::vector<Demonstration>& all,
                                  const std::vector<std::int64_t>& indices);

}  // namespace s2nnds
