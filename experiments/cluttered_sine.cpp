// SPDX-License-Identifier: BSD-3-Clause
// Fig. 5: LASA Sine below an obstacle whose edge is a sine itself.
//
// Expected: every seed `invariant`.
//
// Usage: cluttered_sine --data DIR [--out FOLDER] [--quick]
#include "driver.h"

int main(int argc, char** argv) {
  using namespace s2nnds::experiment;
  return run_driver(argc, argv,
                    {.name = "cluttered_sine",
                     .about = "Fig. 5: a sine below a sine-shaped obstacle",
                     .configs = {"other/cluttered_sine.toml"},
                     .trials = [](const Arguments& arguments) {
                       return with_price(seed_trials("cluttered_sine", arguments));
                     }});
}
