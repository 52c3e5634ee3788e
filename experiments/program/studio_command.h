// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "commands.h"

namespace s2nnds::program {

struct StudioArguments {
  std::string run;                // a run file to look at; "": the folder's
  std::string folder = "studio";  // where drawing, runs and exports lie
  int port = 0;                   // 0: any that is free
};
// Opens the studio until Ctrl-C (experiments/studio). Prints its address, with --json as {"address", "folder"}.
int open_studio(const StudioArguments& arguments, const CommonArguments& common);

struct ReportArguments {
  std::string run;
  std::string out;
};
// One HTML file that shows a run and opens from disk.
int report(const ReportArguments& arguments, const CommonArguments& common);

}  // namespace s2nnds::program
