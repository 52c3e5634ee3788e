// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/data/demonstration.h"
#include "s2nnds/data/recording.h"

namespace s2nnds {

// What is done to recordings before they are demonstrations. Every step reports what it did; a value of 0
// switches a step with a threshold off.
struct CleaningOptions {
  // on, off, or auto: on for csv, npy, mat and hdf5, off for the published and the shipped data sets.
  std::string steps = "auto";
  bool missing = true;         // drop samples with a number that is NaN, infinite or missing
  double most_missing = 0.2;   // largest share of samples that may be dropped so, in [0, 1]
  bool repeated_times = true;  // merge samples with one time stamp into their mean, sort exchanged stamps
  // Samples closer in time than this share of the usual step (90 % of the steps are no longer) came in a burst:
  // they are merged into their mean, in [0, 1).
  double burst = 0.1;
  // Up to three samples away from their place: the speed to there and back is this many times the usual one
  // around and over the whole recording, and nothing is left of the jump behind them. Dropped. >= 0.
  double outlier = 8;
  // Longest step that is no gap, in usual steps (90 % of the steps are no longer), >= 0. Gaps are reported.
  double gap = 10;
  double most_in_gaps = 0.2;  // largest share of the path that may lie within gaps, in [0, 1]
  // At the start and the end, samples within this share of the motion's extent (or within the noise, if that is
  // larger) of the first or last position, less the time in which a motion that starts or stops smoothly is still
  // so near, are rest and cut, where they last half a second or a twentieth of the recording. In [0, 1).
  double rest = 0.001;
  // Seconds, >= 0: where no velocities were recorded, they are the slope of parabolas fitted to so long a
  // piece around each sample, of at least 5 samples and at most a tenth of them. 0: central differences.
  double window = 0.1;
  std::string resample = "none";  // to even steps: none, time, arc_length
  std::int64_t samples = 200;     // of a resampled demonstration, >= 2

  void visit(FieldVisitor& v);  // names each field once
};

// Of one recording.
struct CleanDemonstration {
  Demonstration demonstration;     // in seconds
  std::vector<std::string> steps;  // what was done and found, in words, in order
  // Standard deviation of a coordinate about smooth motion, in the data's unit; NaN: not measured.
  double noise = 0;
};

// The steps in the order of the options, then velocities, resampling, and every stride-th sample. Times in
// seconds. `unit` is for words. Throws Error naming the place for times that go back (more than exchanged
// neighbours), for too many repaired samples, for too much of the path within gaps, and as check_recording.
CleanDemonstration clean(const Recording& recording, const CleaningOptions& options, std::int64_t stride,
                         const std::string& unit);

}  // namespace s2nnds
