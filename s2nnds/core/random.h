// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace s2nnds {

// A named stream of random numbers: the same (seed, name, index) gives the same numbers, and streams of
// different names or indices are independent. A training round draws from (seed, "workspace", round) and so
// on, so a resumed run needs no stored generator state, and verification draws from names that training never
// uses.
class RandomStream {
 public:
  // The stream's start: a 64-bit Mersenne Twister seeded by a hash of the three.
  RandomStream(std::uint64_t seed, std::string_view name, std::uint64_t index = 0);

  double uniform();                         // in [0, 1), 53 bits
  double uniform(double low, double high);  // in [low, high)
  double normal();                          // mean 0, variance 1
  std::size_t below(std::size_t count);     // in {0, ..., count - 1}; throws Error if count is 0

 private:
  std::mt19937_64 engine_;
};

}  // namespace s2nnds
