// SPDX-License-Identifier: BSD-3-Clause
#include "studio_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "experiments/studio/page_files.h"
#include "experiments/studio/run_json.h"
#include "experiments/studio/server.h"
#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/platform.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/summary.h"
#include "s2nnds/runs/threads.h"
#include "writable.h"

namespace s2nnds::program {

namespace fs = std::filesystem;

int open_studio(const StudioArguments& arguments, const CommonArguments& common) {
  const std::string folder = fs::absolute(arguments.folder).lexically_normal().string();
  // Trainings are children of the program without LibTorch, which starts the other where it must.
  const std::string program = fs::path(executable_path()).replace_filename("s2nnds").string();
  studio::Studio studio(folder, program);
  if (!arguments.run.empty()) studio.open_run(arguments.run);
  studio::serve(studio, arguments.port, [&](const std::string& address) {
    if (common.json) {
      fmt::print("{}\n", nlohmann::ordered_json({{"address", address}, {"folder", folder}}).dump());
    } else {
      fmt::print(
          "studio of {}\n  {}\nOpen this address in a browser on this machine. Ctrl-C closes the studio.\n",
          folder, address);
    }
    std::fflush(stdout);
  });
  return kVerified;
}

int report(const ReportArguments& arguments, const CommonArguments& common) {
  set_threads(common.threads);
  const RunRecord record = load_certified_run(arguments.run);
  const std::string path =
      arguments.out.empty() ? fs::path(arguments.run).replace_extension(".html").string() : arguments.out;
  check_writable(path);
  nlohmann::ordered_json run = studio::run_json(record);
  run["final"] = true;
  write_atomic_file(path, studio::report_page(studio::page_files(), record.name, run.dump()), "the report");
  fmt::print("{}: report, guarantee {}\n", path, to_string(record.certificate.guarantee));
  if (common.json) fmt::print("{}\n", summary_json(record, arguments.run));
  return kVerified;
}

}  // namespace s2nnds::program
