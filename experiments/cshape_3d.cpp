// Fig. 3: a kinesthetic C-shaped motion in three dimensions around a ball, ten of fifteen demonstrations
// train.
//
// Expected: every seed `invariant`; the proof takes 170,000 to 400,000 boxes, 1 to 3 s on one thread.
//
// Usage: cshape_3d --data DIR [--out FOLDER] [--quick]
#include "trials.h"

namespace {

using namespace s2nnds::experiment;

Report run(const Arguments& arguments) {
  return report_runs(run_trials(seed_trials("cshape_3d", "other/cshape_3d.toml", arguments), arguments),
                     arguments);
}

}  // namespace

int main(int argc, char** argv) {
  return run_driver(argc, argv, "cshape_3d", "Fig. 3: a motion in three dimensions around a ball", run);
}
