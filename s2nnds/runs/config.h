// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "s2nnds/data/readers.h"
#include "s2nnds/evaluation/rollout.h"
#include "s2nnds/networks/network_options.h"
#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/runs/execution_options.h"
#include "s2nnds/training/orientation_fit.h"
#include "s2nnds/training/trainer_options.h"
#include "s2nnds/verification/conformal.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

// More dimensions a proof is not likely to end in.
inline constexpr std::int64_t most_proved_dimensions = 4;

// How a run's networks are verified, and the settings of each method.
struct VerificationOptions {
  // What `train` ends with: sampled, conformal, or proof. With proof, the prover's open boxes also go back
  // into training, and what is not proved in the end is verified conformally. auto (none here): conformal
  // where f is projected or V a diffeomorphism, else proof; in sweeps proof
  std::optional<Method> method;
  SampledOptions sampled;      // of the method sampled
  ConformalOptions conformal;  // of the method conformal
  ProofOptions proof;          // of the method proof: limits, which end it undecided

  void visit(FieldVisitor& v);  // names each field once
};

// How a run's motion is measured.
struct EvaluationOptions {
  RolloutOptions rollout;  // of the motions from the demonstrations' first points
  // Largest mean distance (normalised, > 0) of a motion from its demonstration, matched in order, with which it counts
  // as following it; up to half as much again where the demonstrations themselves lie farther apart (fidelity.h).
  double fidelity = 0.1;
  // Cells a side of the grid on which the safe area is measured, 0 to 2000; 0: 200 in 2-D, 40 in 3-D. In more
  // dimensions the number of Sobol points in all; 0: 40,000.
  std::int64_t area_cells = 0;
  // Points a side of the grid stored for figures, 3 to 1001; at most 41 in 3-D (81 of a plane with 13 of a phase), no grid
  // in more dimensions.
  std::int64_t grid_points = 161;

  void visit(FieldVisitor& v);  // names each field once
};

// Everything that determines a run: what a TOML file and the command line say, with a default beside every
// field.
struct Config {
  std::string name = "motion";       // of the motion, for file names, tables and messages
  std::string profile = "robust";    // whose defaults the other keys start from; smooth: for four dimensions
  std::int64_t seed = 0;             // of all random numbers of the run, >= 0
  DataOptions data;                  // demonstrations, and how they are split
  ProblemOptions problem;            // workspace X, initial set X0 and unsafe set Xu
  NetworkOptions networks;           // shapes and activations of f, V and B
  TrainerOptions training;           // losses, rates, rounds and stages
  OrientationOptions orientation;    // how orientations follow positions
  VerificationOptions verification;  // how the trained networks are checked
  ExecutionOptions execution;        // how the robot executes the motion, for the proof to cover
  EvaluationOptions evaluation;      // how the trained motion is measured

  // Names each field once. When a profile is read, all fields but `name` first take its defaults.
  void visit(FieldVisitor& v);

  // Replaces what is auto in networks and verification by what is chosen for positions of this dimension.
  void choose_for(std::int64_t dimension);
  // Throws Error with one line where the forms of the networks, once chosen, do not go with each other or with how the
  // run is verified.
  void check_forms() const;
};

// The defaults of a profile. Throws Error on an unknown one.
//   robust: what is made to be proved; smooth: the same in four dimensions; paper: the paper's networks and algorithm;
//   imitation: f alone, fitted without any condition and so without a guarantee, for comparison.
Config default_config(const std::string& profile);

// Reads TOML `text` and the settings "a.b.c=value" on top of it (core/settings.h); `source` names the text in
// messages. Throws Error as read_toml does.
Config parse_config(const std::string& text, const std::string& source,
                    const std::vector<std::string>& settings = {});

// The text of a configuration file. Throws Error if it cannot be read.
std::string read_config_text(const std::string& path);

}  // namespace s2nnds
