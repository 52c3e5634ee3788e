// SPDX-License-Identifier: BSD-3-Clause
// Reads a motion that is shipped inside, evaluates the law x' = -x at its starts, and returns 0 if that went
// well.
#include <cstdio>

#include "s2nnds/core/check.h"
#include "s2nnds/data/handwriting.h"
#include "s2nnds/networks/network_weights.h"

int main() {
  const s2nnds::DemonstrationSet motion = s2nnds::handwriting("Sine");

  s2nnds::NetworkWeights law;
  law.layers.push_back({-s2nnds::Points::Identity(2, 2), {}, s2nnds::Activation::identity});
  law.check();
  for (const s2nnds::Demonstration& demonstration : motion.demonstrations) {
    const s2nnds::Points start = demonstration.position.topRows(1), velocity = law.value(start);
    std::printf("start (%.2f, %.2f) velocity (%.2f, %.2f)\n", start(0, 0), start(0, 1), velocity(0, 0),
                velocity(0, 1));
    if (!(velocity + start).isZero(1e-12)) return 1;
  }

  try {
    s2nnds::handwriting("Scrawl");
  } catch (const s2nnds::Error& error) {
    std::printf("misuse is reported: %s\n", error.what());
    return motion.demonstrations.size() == 7 ? 0 : 1;
  }
  return 1;
}
