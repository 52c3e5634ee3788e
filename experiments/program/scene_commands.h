// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "commands.h"

// The commands before any training: from recordings to a configuration, and a look at what it asks for.
namespace s2nnds::program {

struct NewArguments {
  std::vector<std::string> sources;     // files, folders or patterns
  std::string out;                      // configuration to write
  std::string unit;                     // of the positions; empty: as the files say, else guessed
  std::string time, time_unit;          // data.columns.time, data.time_unit; empty: recognised
  std::vector<std::string> position;    // data.columns.position; empty: recognised
  std::vector<std::string> quaternion;  // data.columns.quaternion; empty: recognised
  std::string quaternion_order;         // data.quaternion_order; empty: as the files tell, else guessed
  double rate = 0;                      // data.rate
};
// Reads, tells what it found, draws it and writes a commented configuration that trains as it stands.
int new_config(const NewArguments& arguments, const CommonArguments& common);

struct PreviewArguments {
  std::string config;
  std::vector<std::string> assignments;  // --set key=value
  std::string out;                       // figure to write
};
// Draws recordings, obstacle, initial set and workspace, tells clearances and whatever is wrong. Throws Error, after
// all that, when training would refuse it.
int preview(const PreviewArguments& arguments, const CommonArguments& common);

}  // namespace s2nnds::program
