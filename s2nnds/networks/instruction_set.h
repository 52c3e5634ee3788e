// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace s2nnds {

// The vector instructions that kernels are compiled for.
enum class InstructionSet { plain, avx2, avx512 };
// Its name: "plain", "avx2", "avx512".
std::string_view to_string(InstructionSet set);

// The best that this processor has; the environment's S2NNDS_ISA (plain, avx2, avx512) picks a lesser one.
// Chosen once. Throws Error on another name, or one that this processor lacks.
InstructionSet instruction_set();

// Of kernels compiled once for each set, those for instruction_set().
template <typename Kernels>
const Kernels& kernels_here(const Kernels& plain, const Kernels& avx2, const Kernels& avx512) {
  switch (instruction_set()) {
    case InstructionSet::avx512:
      return avx512;
    case InstructionSet::avx2:
      return avx2;
    case InstructionSet::plain:
      break;
  }
  return plain;
}

}  // namespace s2nnds
