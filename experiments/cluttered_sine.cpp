// Fig. 5: LASA Sine below an obstacle whose edge is a sine itself.
//
// Expected: every seed `invariant`.
//
// Usage: cluttered_sine --data DIR [--out FOLDER] [--quick]
#include "trials.h"

namespace {

using namespace s2nnds::experiment;

Report run(const Arguments& arguments) {
  return report_runs(
      run_trials(seed_trials("cluttered_sine", "other/cluttered_sine.toml", arguments), arguments),
      arguments);
}

}  // namespace

int main(int argc, char** argv) {
  return run_driver(argc, argv, "cluttered_sine", "Fig. 5: a sine below a sine-shaped obstacle", run);
}
