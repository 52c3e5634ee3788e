// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/core/points.h"
#include "s2nnds/data/frame.h"
#include "s2nnds/data/split.h"
#include "s2nnds/networks/network_weights.h"
#include "s2nnds/problem/box.h"
#include "s2nnds/verification/certificate.h"

namespace s2nnds {

// What a run leaves behind, one struct a group of its HDF5 file. n is the dimension. All but RunData is in
// normalised units (see data/frame.h) unless a field says otherwise.

struct RunConfig {
  std::string text;                                         // the TOML as the user gave it
  std::string resolved;                                     // TOML of every option with its value
  std::vector<std::pair<std::string, std::string>> values;  // the same by dotted key
};

struct RunData {
  std::int64_t dimension = 0;
  Frame frame;
  Split split;
  // Every demonstration as read, in the data's unit and frame and in seconds; those held out included.
  std::vector<Demonstration> demonstrations;

  std::vector<Demonstration> normalized() const { return frame.normalize(demonstrations); }
};

struct RunProblem {
  std::string unsafe;  // Region::describe()
  std::string initial;
  double containment = 0.0;  // 0: off
  double level_band = 0.0;   // eps_B
  Box workspace;
};

inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

// Figures of a motion's quality, in normalised units. Each is named here and in visit, and nowhere else.
struct EvaluationSummary {
  double mse_train = not_measured;
  double mse_test = not_measured;
  double mse_validation = not_measured;  // of runs that hold demonstrations out for it
  double sd_train = not_measured;
  double sd_test = not_measured;
  double dtw_train = not_measured;
  double dtw_test = not_measured;
  double dtw_independent_test = not_measured;
  double safe_area = not_measured;
  double true_safe_area = not_measured;
  double safe_area_ratio = not_measured;

  void visit(FieldVisitor& v);
};

// How long each step of a run took, in seconds of wall clock.
struct RunTiming {
  double training = not_measured;
  double first_clean_round = not_measured;  // of training, until a search ended without counterexamples
  double verification_sampled = not_measured;
  double verification_conformal = not_measured;
  double verification_proof = not_measured;  // proof and disturbance_margin included
  double proof = not_measured;
  double disturbance_margin = not_measured;
  double evaluation = not_measured;

  void visit(FieldVisitor& v);
};

struct StoredRollout {
  std::string start_kind;  // where it started: "test", "train" (a demonstration's first point), "grid"
  std::string stop;        // to_string(StopReason)
  Vector time;             // [M]
  Points position;         // [M, n]
};

// Fields on a grid, for figures. Values at (axis_0[i], axis_1[j], ...), the last axis running fastest:
// N = N0 N1 ... of them.
struct Grid {
  std::vector<Vector> axes;  // n axes of N0, N1, ... coordinates
  Vector unsafe;             // [N] level of the unsafe set
  Vector initial;            // [N] level of the initial set
  Vector V;                  // [N]
  Vector B;                  // [N]
  Points velocity;           // [N, n] f
};

// What training needs to go on from where it stopped, beside the networks.
struct Checkpoint {
  std::int64_t round = 0;  // rounds done
  bool finished = false;
  std::vector<std::pair<std::string, Points>> points;   // [any, any] by name: pools, optimiser moments
  std::vector<std::pair<std::string, double>> numbers;  // by a name other than round and finished
};

struct RunRecord {
  std::string program_version;
  std::string library_versions;
  std::string created;  // ISO 8601; with the seconds in `history`, `certificate` and `timing` all that
                        // depends on time
  std::string name;
  std::int64_t seed = 0;
  RunConfig config;
  RunData data;
  RunProblem problem;
  std::vector<std::pair<std::string, Vector>> history;  // one column [rounds] a name
  Networks networks;
  Certificate certificate;
  std::vector<std::pair<std::string, Points>>
      open_boxes;  // by condition, [k, 2n] lower then upper corner: not proved
  EvaluationSummary evaluation;
  RunTiming timing;
  std::vector<StoredRollout> rollouts;
  std::optional<Grid> grid;
  std::optional<Checkpoint> checkpoint;
};

inline constexpr std::int64_t run_schema_version = 2;

std::string time_stamp();  // now, UTC: "2024-05-31T12:00:00Z"

// Throws Error naming the item whose shape, index or value does not fit: saving checks what loading checks.
void check_record(const RunRecord& record);

// Replaces the file at `path` by the record, or leaves the old one when it throws Error. Equal records give
// equal bytes.
void save_run(const std::string& path, const RunRecord& record);

// Throws Error naming the file and the item: a missing or truncated file, another schema, wrong shapes,
// weights that are not finite.
RunRecord load_run(const std::string& path);

}  // namespace s2nnds
