// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/instruction_set.h"

#include <cstdlib>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

InstructionSet best_of_this_processor() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")) {
    return InstructionSet::avx512;
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::avx2;
#endif
  return InstructionSet::plain;
}

InstructionSet choose() {
  const InstructionSet best = best_of_this_processor();
  const char* wish = std::getenv("S2NNDS_ISA");
  if (wish == nullptr || *wish == '\0') return best;
  for (const InstructionSet set : {InstructionSet::plain, InstructionSet::avx2, InstructionSet::avx512}) {
    if (wish == to_string(set) && set <= best) return set;
  }
  fail("S2NNDS_ISA: found \"{}\", expected plain, avx2 or avx512, and one that this processor has", wish);
}

}  // namespace

std::string_view to_string(InstructionSet set) {
  switch (set) {
    case InstructionSet::plain:
      return "plain";
    case InstructionSet::avx2:
      return "avx2";
    case InstructionSet::avx512:
      return "avx512";
  }
  fail("instruction set: found the value {}, expected 0 to 2", static_cast<int>(set));
}

InstructionSet instruction_set() {
  static const InstructionSet chosen = choose();
  return chosen;
}

}  // namespace s2nnds
