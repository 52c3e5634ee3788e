// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/random.h"

#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_int_distribution.hpp>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// SplitMix64's mixing step (Steele, Lea, Flood 2014): spreads nearby inputs over all 64 bits.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

std::uint64_t key(std::uint64_t seed, std::string_view name, std::uint64_t index) {
  std::uint64_t h = mix(seed);
  for (unsigned char c : name) h = mix(h ^ c);
  return mix(h ^ mix(index));
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view name, std::uint64_t index)
    : engine_(key(seed, name, index)) {}

double RandomStream::uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

double RandomStream::uniform(double low, double high) { return low + (high - low) * uniform(); }

double RandomStream::normal() { return boost::random::normal_distribution<double>()(engine_); }

std::size_t RandomStream::below(std::size_t count) {
  check(count > 0, "random: below(0) has no value to return");
  return boost::random::uniform_int_distribution<std::size_t>(0, count - 1)(engine_);
}

}  // namespace s2nnds
