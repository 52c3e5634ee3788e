// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/region_sampler.h"

#include <algorithm>
#include <queue>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr int kMostBisections = 4096;
constexpr double kGoodCover = 0.05;           // share of the inner volume that may be undecided
constexpr std::size_t kSearchDraws = 200000;  // draws of which none hit: the region counts as empty
constexpr std::size_t kBatch = 1024;
constexpr std::size_t kDrawnAnew = 8;  // one point in so many, where there is a stock

struct Undecided {
  Box box;
  double volume;
  bool operator<(const Undecided& other) const { return volume < other.volume; }
};

}  // namespace

RegionSampler::RegionSampler(RegionPtr region, const Box& within) : region_(std::move(region)) {
  check(within.is_finite() && within.dimension() == region_->dimension(),
        "region sampler: expected a finite box of dimension {}", region_->dimension());
  pave(within);
  if (cover_.empty() || volume_inside_ > 0.0) return;
  // No box lies inside: look for a point, so that empty() can be trusted.
  RandomStream random(0, "region-sampler");
  Points candidates(kBatch, within.dimension());
  std::vector<bool> accepted(kBatch);
  for (std::size_t drawn = 0; drawn < kSearchDraws; drawn += kBatch) {
    draw(candidates, accepted, random);
    if (std::find(accepted.begin(), accepted.end(), true) != accepted.end()) return;
  }
  cover_.clear();
  volume_cover_ = 0.0;
}

void RegionSampler::pave(const Box& within) {
  std::priority_queue<Undecided> undecided;
  double undecided_volume = 0.0;
  const auto place = [&](const Box& box) {
    const double volume = box.volume();
    const Location location = volume > 0.0 ? region_->classify(box) : Location::outside;
    if (location == Location::outside) return;
    if (location == Location::unknown) {
      undecided.push({box, volume});
      undecided_volume += volume;
      return;
    }
    cover_.push_back(box);
    inside_.push_back(true);
    volume_inside_ += volume;
  };
  place(within);
  for (int k = 0; k < kMostBisections && !undecided.empty() && undecided_volume > kGoodCover * volume_inside_;
       ++k) {
    const Undecided largest = undecided.top();
    undecided.pop();
    undecided_volume -= largest.volume;
    const auto [lower, upper] = largest.box.bisect(largest.box.widest_side());
    place(lower);
    place(upper);
  }
  for (; !undecided.empty(); undecided.pop()) {
    cover_.push_back(undecided.top().box);
    inside_.push_back(false);
  }
  for (const Box& box : cover_) {
    volume_cover_ += box.volume();
    cumulative_volume_.push_back(volume_cover_);
  }
}

// Fills `candidates` with uniform points of the cover and says which of them are in the region.
void RegionSampler::draw(Points& candidates, std::vector<bool>& accepted, RandomStream& random) const {
  std::vector<Eigen::Index> doubtful;
  for (Eigen::Index k = 0; k < candidates.rows(); ++k) {
    const double at = random.uniform(0.0, volume_cover_);
    const auto found = std::upper_bound(cumulative_volume_.begin(), cumulative_volume_.end(), at);
    const auto chosen = static_cast<std::size_t>(
        std::min(found - cumulative_volume_.begin(), static_cast<std::ptrdiff_t>(cover_.size()) - 1));
    for (Eigen::Index i = 0; i < candidates.cols(); ++i) {
      candidates(k, i) = random.uniform(cover_[chosen].lower[i], cover_[chosen].upper[i]);
    }
    accepted[static_cast<std::size_t>(k)] = inside_[chosen];
    if (!inside_[chosen]) doubtful.push_back(k);
  }
  Points questions(static_cast<Eigen::Index>(doubtful.size()), candidates.cols());
  for (std::size_t j = 0; j < doubtful.size(); ++j) {
    questions.row(static_cast<Eigen::Index>(j)) = candidates.row(doubtful[j]);
  }
  const Vector level = region_->level(questions);
  for (std::size_t j = 0; j < doubtful.size(); ++j) {
    accepted[static_cast<std::size_t>(doubtful[j])] = level[static_cast<Eigen::Index>(j)] <= 0.0;
  }
}

Points RegionSampler::sample(std::size_t count, RandomStream& random) const {
  check(!empty(), "region sampler: {} has no points within the box", region_->describe());
  Points samples(static_cast<Eigen::Index>(count), region_->dimension());
  Points candidates(static_cast<Eigen::Index>(std::clamp<std::size_t>(2 * count, 64, kBatch)),
                    region_->dimension());
  std::vector<bool> accepted(static_cast<std::size_t>(candidates.rows()));
  const std::size_t anew = stock_.rows() > 0 ? (count + kDrawnAnew - 1) / kDrawnAnew : count;
  Eigen::Index filled = 0;
  while (filled < static_cast<Eigen::Index>(anew)) {
    draw(candidates, accepted, random);
    for (Eigen::Index k = 0; k < candidates.rows() && filled < static_cast<Eigen::Index>(anew); ++k) {
      if (accepted[static_cast<std::size_t>(k)]) samples.row(filled++) = candidates.row(k);
    }
  }
  for (; filled < samples.rows(); ++filled)
    samples.row(filled) =
        stock_.row(static_cast<Eigen::Index>(random.below(static_cast<std::size_t>(stock_.rows()))));
  return samples;
}

void RegionSampler::keep_stock(std::size_t count, RandomStream& random) {
  if (!empty()) stock_ = sample(count, random);
}

std::optional<RegionSampler> sampler_of(const RegionPtr& region, const Box& within) {
  if (!region) return std::nullopt;
  RegionSampler sampler(region, within);
  if (sampler.empty()) return std::nullopt;
  return sampler;
}

Points uniform_points(const Box& box, std::int64_t count, RandomStream& random) {
  Points x(count, box.dimension());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    for (Eigen::Index k = 0; k < x.cols(); ++k) x(i, k) = random.uniform(box.lower[k], box.upper[k]);
  }
  return x;
}

}  // namespace s2nnds
