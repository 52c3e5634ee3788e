// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>

#include "s2nnds/problem/region_sampler.h"

namespace s2nnds {

// As sampler_of(), for training: in more than few_dimensions it keeps a stock of 20,000 points, drawn from the stream
// `name`, since a thin set's would cost more than all else. Whatever calls a run verified draws points of its own.
std::optional<RegionSampler> training_sampler(const RegionPtr& region, const Box& within,
                                              std::string_view name);

}  // namespace s2nnds
