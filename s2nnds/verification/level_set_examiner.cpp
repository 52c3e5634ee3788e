// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/level_set_examiner.h"

#include <limits>

#include "s2nnds/verification/band_bound.h"
#include "s2nnds/verification/rounding.h"

namespace s2nnds {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double kSmall = 0.03;  // share by which a rate varies that hardly does

}  // namespace

LevelSetExaminer::LevelSetExaminer(const ProofFunctions& functions, double resolution,
                                   std::unique_ptr<Perturbation> perturbation, double scale,
                                   double hopeless_width)
    : TileExaminer(functions, resolution),
      perturbation_(std::move(perturbation)),
      scale_(scale),
      hopeless_width_(hopeless_width) {}

void LevelSetExaminer::look(int count) {
  if (count == 0) {
    const TileForm& form = barrier_.value(tile_);
    meets_ = !((form.lower(tile_) > 0.0) || (form.upper(tile_) < 0.0));
  } else if (count == 1) {
    const TileForm form = barrier_.lie_derivative(tile_);
    rate() = upper_within(form, barrier_.value(tile_), 0.0, tile_);
    const TileRow upper = form.upper(tile_);
    steady_rate() = (upper - form.value < kSmall * upper.abs()).select(form.value, -infinity);
    cut_for(form);
  } else {
    const TileRow own = perturbation_->work(barrier_, tile_) * slack;
    carried_ = (own < carried_).select(own, carried_);
    hopeless_ = steady_rate() + (1.0 - kSmall) * scale_ * own > 0.0;
  }
}

std::optional<BoxStatus> LevelSetExaminer::judge(int count, const Lane& lane) {
  const Eigen::Index at = lane.at;
  if (count == 0) return meets_(at) ? std::nullopt : std::optional(BoxStatus::proved);
  if (rate()(at) + scale_ * carried_(at) * slack < -1e-300) {
    on_proved(lane, {rate()(at), carried_(at)});
    return BoxStatus::proved;
  }
  if (count == 1 && rate()(at) < 0.0) return std::nullopt;
  const bool hopeless = count > 1 && hopeless_(at) && lane.width() <= hopeless_width_;
  return lane.narrow || hopeless ? BoxStatus::abandoned : BoxStatus::undecided;
}

}  // namespace s2nnds
