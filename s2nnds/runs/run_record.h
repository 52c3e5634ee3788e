// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/core/points.h"
#include "s2nnds/data/frame.h"
#include "s2nnds/data/split.h"
#include "s2nnds/networks/network_weights.h"
#include "s2nnds/networks/orientation_law.h"
#include "s2nnds/problem/box.h"
#include "s2nnds/verification/certificate.h"

namespace s2nnds {

// The configuration of a run.
struct RunConfig {
  std::string text;                                         // the TOML as the user gave it
  std::string resolved;                                     // TOML of every option with its value
  std::vector<std::pair<std::string, std::string>> values;  // the same by dotted key
};

// The demonstrations of a run.
struct RunData {
  std::int64_t dimension = 0;  // n, of positions
  Frame frame;                 // how data as read becomes normalised
  Split split;                 // which demonstrations train, test and validate
  // Every demonstration as read, in the data's unit and frame and in seconds; those held out included.
  std::vector<Demonstration> demonstrations;
  std::vector<std::string> report = {};  // what was recognised and cleaned while reading, a line each

  // All demonstrations in normalised units. Throws Error as Frame::normalize does.
  std::vector<Demonstration> normalized() const { return frame.normalize(demonstrations); }
};

// The sets of a run.
struct RunProblem {
  std::string frame = "normalised";  // whose unit and frame the words below are in: data, normalised
  std::string unsafe;                // the unsafe set Xu in words: Region::describe()
  std::string initial;               // the initial set X0 in words
  // Share of the workspace, in (0, 1), within which the safe set must lie; 0: off.
  double containment = 0.0;
  double level_band = 0.0;  // eps_B >= 0: Bdot < 0 is asked for where |B| <= level_band
  Box workspace;            // X
  // The files that the sets are made from, by the names in the configuration, and their bytes.
  std::map<std::string, std::string> files;
};

// Stands for a figure that was not measured: NaN.
inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

// Figures of a motion's quality, in normalised units (trajectory_metrics.h, safe_area.h). Those of test and
// validation are measured only where such demonstrations are held out. Each is named here and in visit, and
// nowhere else.
struct EvaluationSummary {
  double mse_train = not_measured;  // mean of |f(x) - xdot|^2 over the samples of training demonstrations
  double mse_test = not_measured;   // the same, of test demonstrations
  double mse_validation = not_measured;  // the same, of validation demonstrations
  double sd_train = not_measured;        // standard deviation of |f(x) - xdot|, training demonstrations
  double sd_test = not_measured;         // the same, of test demonstrations
  // Dynamic time warping distance (dtw) of rollouts to training demonstrations, mean over these.
  double dtw_train = not_measured;
  double dtw_test = not_measured;              // the same, to test demonstrations
  double dtw_independent_test = not_measured;  // dtw_independent instead: each axis warped by itself, a sum
  // Over the training demonstrations (fidelity.h): the largest mean distance of a motion from its own, the
  // largest distance at all, and how many count as not followed.
  double deviation_mean = not_measured;
  double deviation_largest = not_measured;
  double not_followed = not_measured;
  double starts_not_followed =
      not_measured;  // of 32 starts that cover X0, those that follow no demonstration
  // Degrees between the orientations of a demonstration and of the motion from its first pose, matched in order by
  // dynamic time warping of these: the mean over pairs, and the largest. Of training and test demonstrations.
  double orientation_mean_train = not_measured, orientation_largest_train = not_measured;
  double orientation_mean_test = not_measured, orientation_largest_test = not_measured;
  double safe_area = not_measured;        // of {B <= 0} within X; volume in 3-D
  double true_safe_area = not_measured;   // of the starts whose rollout is safe and reaches the goal
  double safe_area_ratio = not_measured;  // safe_area / true_safe_area

  void visit(FieldVisitor& v);  // names each field once
};

// How long each step of a run took, in seconds of wall clock.
struct RunTiming {
  double training = not_measured;                // train(), over all its continuations
  double first_clean_round = not_measured;       // of training, until a search ended without counterexamples
  double verification_sampled = not_measured;    // the last verify() by samples
  double verification_conformal = not_measured;  // the last verify() by conformal calibration
  double verification_proof = not_measured;  // the last verify() by proof: proof, disturbance_margin and more
  double proof = not_measured;               // prove() alone
  double disturbance_margin = not_measured;  // disturbance_margin() alone
  double execution = not_measured;           // prove_executed() alone
  double evaluation = not_measured;          // evaluate()

  void visit(FieldVisitor& v);  // names each field once
};

// A motion xdot = f(x), for figures.
struct StoredRollout {
  std::string start_kind;   // where it started: "test", "train" (a demonstration's first point), "grid"
  std::string stop;         // why it ended: to_string(StopReason)
  Vector time;              // [M] normalised, from 0
  Points position;          // [M, n]
  Points orientation = {};  // [M, 4] unit quaternions (w, x, y, z); [0, 0] without
};

// Fields on a grid, for figures. Values at (axis_0[i], axis_1[j], ...), the last axis running fastest:
// N = N0 N1 ... of them.
struct Grid {
  std::vector<Vector> axes;  // n axes of N0, N1, ... coordinates
  Vector unsafe;             // [N] level of the unsafe set
  Vector initial;            // [N] level of the initial set
  Vector V;                  // [N] Lyapunov function
  Vector B;                  // [N] barrier
  Points velocity;           // [N, n] f
};

// What training needs to go on from where it stopped, beside the networks.
struct Checkpoint {
  std::int64_t round = 0;                               // rounds done
  bool finished = false;                                // training has ended; there is nothing to go on with
  std::vector<std::pair<std::string, Points>> points;   // [any, any] by name: pools, optimiser moments
  std::vector<std::pair<std::string, double>> numbers;  // by a name other than round and finished
};

// What a run leaves behind, one struct a group of its HDF5 file. n is the dimension. All but RunData is in
// normalised units (see data/frame.h) unless a field says otherwise.
struct RunRecord {
  std::string program_version;   // of the program that made it, see version.h
  std::string library_versions;  // of what it was linked with
  // ISO 8601; with the seconds in `history`, `certificate` and `timing` all that depends on time.
  std::string created;
  std::string name;                                     // Config::name
  std::int64_t seed = 0;                                // Config::seed
  RunConfig config;                                     // as given, and with every value
  RunData data;                                         // demonstrations as read
  RunProblem problem;                                   // the sets, in words and numbers
  std::vector<std::pair<std::string, Vector>> history;  // one column [rounds] a name
  Networks networks;                                    // f, V and B as trained so far
  std::optional<OrientationLaw> orientation;            // of poses, once f, V and B are trained
  Certificate certificate;                              // what is known of these networks
  // By condition, [k, 2n] lower then upper corner: boxes that were not proved.
  std::vector<std::pair<std::string, Points>> open_boxes;
  // [k, n + 1]: samples of the training demonstrations, each with the largest push (N s) there that does not
  // leave the safe set; [0, 0] where execution.damping is 0.
  Points pushes;
  EvaluationSummary evaluation;          // figures of the motion's quality
  std::vector<std::string> remarks;      // on the motion, a sentence each (motion_report.h)
  RunTiming timing;                      // seconds of each step
  std::vector<StoredRollout> rollouts;   // for figures
  std::optional<Grid> grid;              // for figures; none in more than three dimensions
  std::optional<Checkpoint> checkpoint;  // to go on with training; none before it began
};

// Of the run files that this program writes, and the only one that it reads.
inline constexpr std::int64_t run_schema_version = 5;

std::string time_stamp();  // now, UTC: "2024-05-31T12:00:00Z"

// Throws Error naming the item whose shape, index or value does not fit: saving checks what loading checks.
void check_record(const RunRecord& record);

// Replaces the file at `path` by the record, or leaves the old one when it throws Error. Equal records give
// equal bytes.
void save_run(const std::string& path, const RunRecord& record);

// The bisections (BisectionTree::bytes) that proved each condition, by its name.
using ProofCovers = std::vector<std::pair<std::string, std::vector<std::uint8_t>>>;

// Replaces the file at `path` by the record's proof, which s2nnds-check reads: networks, scope and covers
// alone, where save_run() puts them, and /cover/NAME.
void save_proof(const std::string& path, const RunRecord& record, const ProofCovers& covers);

// Throws Error naming the file and the item: a missing or truncated file, another schema, wrong shapes,
// weights that are not finite.
RunRecord load_run(const std::string& path);

}  // namespace s2nnds
