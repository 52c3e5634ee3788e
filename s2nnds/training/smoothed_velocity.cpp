#include "s2nnds/training/smoothed_velocity.h"

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/training/phase_regression.h"

namespace s2nnds {
namespace {

constexpr int kCopies = 3;  // of each demonstration in the tube

}  // namespace

std::vector<Demonstration> smoothed(std::vector<Demonstration> demonstrations, double share) {
  check(share >= 0.0 && share <= 1.0, "smoothing: the share is {}, expected 0 to 1", share);
  if (share == 0.0 || demonstrations.size() < 2) return demonstrations;
  const PhaseRegression regression(demonstrations);
  for (Demonstration& each : demonstrations) {
    each.velocity += share * (regression.velocity(each.position) - each.velocity);
  }
  return demonstrations;
}

std::vector<Demonstration> tube(const std::vector<Demonstration>& demonstrations, double width,
                                std::uint64_t seed) {
  check(width >= 0.0, "tube: the width is {}, expected >= 0", width);
  std::vector<Demonstration> copies;
  if (width == 0.0 || demonstrations.size() < 2) return copies;
  const PhaseRegression regression(demonstrations);
  RandomStream random(seed, "tube");
  for (int k = 0; k < kCopies; ++k) {
    for (Demonstration copy : demonstrations) {
      for (Eigen::Index i = 0; i < copy.position.size(); ++i)
        copy.position.data()[i] += width * random.normal();
      copy.velocity = regression.velocity(copy.position);
      copies.push_back(std::move(copy));
    }
  }
  return copies;
}

}  // namespace s2nnds
