#pragma once

#include <string>
#include <vector>

#include "s2nnds/data/demonstration.h"
#include "s2nnds/evaluation/rollout.h"

namespace s2nnds {

struct RobustnessOptions {
  int grid = 20;         // starts a side of a grid over the workspace (8 in 3-D); those in Xu are left out
  int repetitions = 10;  // perturbed starts and pushes of each demonstration's start
  double perturbation = 0.1;             // standard deviation, per axis, of what is added to a start
  double push = 0.1;                     // length of the displacement in mid-motion, in a random direction
  std::int64_t boundary_samples = 4000;  // of Xu, to measure distances to (eight times as many in 3-D)
  RolloutOptions rollout = {};
};

// How a set of motions ended. Normalised units.
struct MotionOutcomes {
  std::string starts;  // "grid", "perturbed", "pushed"
  std::int64_t motions = 0;
  double converged = 0.0;  // share that reached the goal (without touching Xu or leaving X)
  double safe = 0.0;       // share that neither touched Xu nor left X, as far as it could be followed at all
  // Of motions that start in {B <= 0} and whose displacement, if any, ends there: what a certificate of f and
  // B speaks of. 0 of them without a B.
  std::int64_t covered = 0;
  double covered_converged = 0.0;  // share of these that reached the goal, NaN if there are none
  double closest = 0.0;            // least distance of a safe motion's points to Xu, NaN if none is safe
  double mean_closest = 0.0;       // mean over the safe motions of their least distances
  double time_to_goal = 0.0;       // median over those that converged, NaN if none did
};

// Rolls f out from a grid of starts, from starts beside the demonstrations' first points, and from those
// first points with a sudden displacement half way (of the time to the goal; none where the motion does not
// arrive even so); a displacement that ends in Xu or outside X counts as unsafe. As in roll_out, entering the
// margin is leaving X. Random numbers: streams "robustness/..." of `seed`. Distances are measured to samples
// of Xu's boundary, so they are too large, by the largest gap between these at most; NaN without an obstacle.
// `barrier`: the B that f was certified with, if any.
std::vector<MotionOutcomes> measure_robustness(const NetworkWeights& f, const NetworkWeights* barrier,
                                               const SafetyProblem& problem,
                                               const std::vector<Demonstration>& demonstrations,
                                               std::uint64_t seed, const RobustnessOptions& options = {});

}  // namespace s2nnds
