#include "s2nnds/training/smoothed_velocity.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/random.h"
#include "s2nnds/training/phase_regression.h"

namespace s2nnds {
namespace {

// The process is fitted to a part of the samples, which lie close together: so many of a demonstration at
// most, and of all of them.
constexpr Eigen::Index kOfOne = 125, kOfAll = 640;
constexpr int kCopies = 3;         // of each demonstration in the tube
constexpr std::size_t kFolds = 5;  // demonstrations that are left out in turn, at most
constexpr double kLengths[] = {0.05, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.56}, kNoises[] = {0.1, 0.3, 0.8, 1.6};

struct Setting {
  double length, noise;  // of positions; of velocities, standard deviation
};
struct Samples {
  Points position, velocity;
};

// Evenly spaced samples of a demonstration, `most` at most.
Demonstration thinned(const Demonstration& whole, Eigen::Index most) {
  const Eigen::Index stride = (whole.samples() + most - 1) / most;
  const auto rows = Eigen::seqN(0, (whole.samples() + stride - 1) / stride, stride);
  return {whole.time(rows), whole.position(rows, Eigen::all), whole.velocity(rows, Eigen::all)};
}

Samples samples_of(std::vector<Demonstration> demonstrations, Eigen::Index most) {
  for (Demonstration& each : demonstrations) each = thinned(each, most);
  return {stack_positions(demonstrations), stack_velocities(demonstrations)};
}

Points kernel(const Points& a, const Points& b, double length) {
  Points squared = -2.0 * a * b.transpose();
  squared.colwise() += a.rowwise().squaredNorm();
  squared.rowwise() += b.rowwise().squaredNorm().transpose();
  return (squared.array() * (-0.5 / (length * length))).exp();
}

Points mean(const Samples& samples, const Setting& setting, const Points& at) {
  Points gram = kernel(samples.position, samples.position, setting.length);
  gram.diagonal().array() += setting.noise * setting.noise;
  return kernel(at, samples.position, setting.length) * gram.llt().solve(samples.velocity);
}

// One demonstration left out: what it would be predicted from, and itself.
struct Fold {
  Samples rest, held;
};

std::vector<Fold> folds_of(const std::vector<Demonstration>& demonstrations, Eigen::Index most) {
  std::vector<Fold> folds;
  for (std::size_t i = 0; i < std::min(kFolds, demonstrations.size()); ++i) {
    std::vector<Demonstration> rest = demonstrations;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    folds.push_back({samples_of(rest, (most + 1) / 2), samples_of({demonstrations[i]}, most)});
  }
  return folds;
}

Setting best_setting(const std::vector<Fold>& folds) {
  Setting best{kLengths[0], kNoises[0]};
  double least = std::numeric_limits<double>::infinity();
  for (const double length : kLengths) {
    for (const double noise : kNoises) {
      double error = 0.0;
      for (const Fold& fold : folds) {
        error += (mean(fold.rest, {length, noise}, fold.held.position) - fold.held.velocity)
                     .rowwise()
                     .squaredNorm()
                     .mean();
      }
      if (error >= least) continue;
      least = error;
      best = {length, noise};
    }
  }
  return best;
}

// The average of two regressions that err in different ways: a Gaussian process knows only where a sample is,
// the other also what comes before and after it. For at least two demonstrations.
class Consensus {
 public:
  explicit Consensus(const std::vector<Demonstration>& demonstrations) : phases_(demonstrations) {
    const auto count = static_cast<Eigen::Index>(demonstrations.size());
    const Eigen::Index most = std::clamp<Eigen::Index>(kOfAll / count, 2, kOfOne);
    samples_ = samples_of(demonstrations, most);
    setting_ = best_setting(folds_of(demonstrations, most));
  }

  Points velocity(const Points& x) const { return 0.5 * (mean(samples_, setting_, x) + phases_.velocity(x)); }

 private:
  PhaseRegression phases_;
  Samples samples_;
  Setting setting_{};
};

}  // namespace

std::vector<Demonstration> smoothed(std::vector<Demonstration> demonstrations, double share) {
  check(share >= 0.0 && share <= 1.0, "smoothing: the share is {}, expected 0 to 1", share);
  if (share == 0.0 || demonstrations.size() < 2) return demonstrations;
  const Consensus consensus(demonstrations);
  for (Demonstration& each : demonstrations) {
    each.velocity += share * (consensus.velocity(each.position) - each.velocity);
  }
  return demonstrations;
}

std::vector<Demonstration> tube(const std::vector<Demonstration>& demonstrations, double width,
                                std::uint64_t seed) {
  check(width >= 0.0, "tube: the width is {}, expected >= 0", width);
  std::vector<Demonstration> copies;
  if (width == 0.0 || demonstrations.size() < 2) return copies;
  const Consensus consensus(demonstrations);
  RandomStream random(seed, "tube");
  for (int k = 0; k < kCopies; ++k) {
    for (Demonstration copy : demonstrations) {
      for (Eigen::Index i = 0; i < copy.position.size(); ++i)
        copy.position.data()[i] += width * random.normal();
      copy.velocity = consensus.velocity(copy.position);
      copies.push_back(std::move(copy));
    }
  }
  return copies;
}

}  // namespace s2nnds
