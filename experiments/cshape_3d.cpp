// SPDX-License-Identifier: BSD-3-Clause
// Fig. 3: a kinesthetic C-shaped motion in three dimensions around a ball, ten of fifteen demonstrations
// train.
//
// Expected: every seed `invariant`; the proof takes 170,000 to 400,000 boxes, 1 to 3 s on one thread.
//
// Usage: cshape_3d --data DIR [--out FOLDER] [--quick]
#include "driver.h"

int main(int argc, char** argv) {
  using namespace s2nnds::experiment;
  return run_driver(
      argc, argv,
      {.name = "cshape_3d",
       .about = "Fig. 3: a motion in three dimensions around a ball",
       .configs = {"other/cshape_3d.toml"},
       .trials = [](const Arguments& arguments) { return with_price(seed_trials("cshape_3d", arguments)); }});
}
