// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "s2nnds/data/readers.h"
#include "s2nnds/evaluation/rollout.h"
#include "s2nnds/networks/network_options.h"
#include "s2nnds/problem/safety_problem.h"
#include "s2nnds/training/trainer_options.h"
#include "s2nnds/verification/conformal.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds {

struct VerificationOptions {
  // What `train` ends with: sampled, conformal, or proof. With proof, the prover's open boxes also go back
  // into training.
  Method method = Method::proof;
  SampledOptions sampled;
  ConformalOptions conformal;
  ProofOptions proof;

  void visit(FieldVisitor& v);
};

struct EvaluationOptions {
  RolloutOptions rollout;
  std::int64_t area_cells = 0;     // cells a side of the safe-area grid; 0: 200 in 2-D, 40 in 3-D
  std::int64_t grid_points = 161;  // points a side of the grid stored for figures (2-D; 41 in 3-D)

  void visit(FieldVisitor& v);
};

// Everything that determines a run: what a TOML file and the command line say, with a default beside every
// field.
struct Config {
  std::string name = "motion";
  std::string profile = "robust";  // whose defaults the other keys start from: robust, paper, imitation
  std::int64_t seed = 0;
  DataOptions data;
  ProblemOptions problem;
  NetworkOptions networks;
  TrainerOptions training;
  VerificationOptions verification;
  EvaluationOptions evaluation;

  void visit(FieldVisitor& v);
};

// The defaults of a profile. Throws Error on an unknown one.
//   robust: what is made to be proved; paper: the paper's networks, losses and algorithm;
//   imitation: f alone, fitted without any condition and so without a guarantee, for comparison.
Config default_config(const std::string& profile);

// Reads TOML `text` and the settings "a.b.c=value" on top of it (core/settings.h); `source` names the text in
// messages. Throws Error as read_toml does.
Config parse_config(const std::string& text, const std::string& source,
                    const std::vector<std::string>& settings = {});

// The text of a configuration file. Throws Error if it cannot be read.
std::string read_config_text(const std::string& path);

}  // namespace s2nnds
