// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/training_sampler.h"

#include <string>

#include "s2nnds/training/trainer_options.h"

namespace s2nnds {
namespace {

constexpr std::size_t kStock = 20000;

}  // namespace

std::optional<RegionSampler> training_sampler(const RegionPtr& region, const Box& within,
                                              std::string_view name) {
  std::optional<RegionSampler> sampler = sampler_of(region, within);
  if (sampler && within.dimension() > few_dimensions) {
    RandomStream random(0, "stock/" + std::string(name));
    sampler->keep_stock(kStock, random);
  }
  return sampler;
}

}  // namespace s2nnds
