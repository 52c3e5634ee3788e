// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

// The commands of the program, one function each. They return the exit code: 0 done and verified, 3 trained
// or checked but not verified; bad input throws s2nnds::Error (exit code 2).
namespace s2nnds::program {

inline constexpr int kVerified = 0;
inline constexpr int kInternalFailure = 1;
inline constexpr int kBadInput = 2;
inline constexpr int kNotVerified = 3;

struct CommonArguments {
  std::string data;        // --data: where the data files are
  int threads = 0;         // --threads: 0 is all cores
  bool json = false;       // --json: one JSON object as the last line of stdout
  char** words = nullptr;  // the command line as main() got it
};

struct TrainArguments {
  std::string config;
  std::vector<std::string> assignments;  // --set key=value
  std::optional<std::int64_t> seed;
  std::string out;
  std::string resume;
  std::string until = "finished";  // finished, certified
};
int train(const TrainArguments& arguments, const CommonArguments& common);

struct AdaptArguments {
  std::string run;
  std::vector<std::string> assignments;  // --set key=value
  std::string out;
};
int adapt(const AdaptArguments& arguments, const CommonArguments& common);

struct VerifyArguments {
  std::string run;
  std::string method = "conformal";
  std::string artifact;  // proof: where the boxes that prove it go; "": nowhere
  std::optional<std::int64_t> samples;
  std::optional<double> epsilon, beta;
  std::string speed;                     // --speed auto: look for the certified range; "": do not
  std::vector<std::string> assignments;  // --set execution.key=value
};
int verify(const VerifyArguments& arguments, const CommonArguments& common);

struct EvaluateArguments {
  std::string run;
  // Of train, test, validation: those whose demonstrations' errors are told one by one.
  std::vector<std::string> splits;
};
int evaluate(const EvaluateArguments& arguments, const CommonArguments& common);

// Which displacements of an obstacle are looked at, of `range` and `export --range`.
struct RangeChoice {
  std::string obstacle = "all";  // a number from 0, or all
  double stretch = 0.8;
  // In the data's unit: one number, a radius; [places], half sizes of a box; none: as far as it goes
  std::vector<double> within = {};
};

struct ExportArguments {
  std::string run;
  std::string format;
  std::string precision = "float";       // of f in a C++ header
  RangeChoice range = {.obstacle = ""};  // "": a header for the scene as it is alone
  std::string out;
};
int export_policy(const ExportArguments& arguments, const CommonArguments& common);

struct PlotArguments {
  std::string run;
  std::string out;
};
int plot(const PlotArguments& arguments);

// Recordings of others, through the Python module import_recordings; its words are its own.
int import_recordings(const std::vector<std::string>& words);

struct InfoArguments {
  std::string run;
  bool all = false;  // details after the first screen
};
int info(const InfoArguments& arguments, const CommonArguments& common);

}  // namespace s2nnds::program
