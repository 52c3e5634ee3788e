#include "s2nnds/networks/dense_kernels.h"

#include <cstdlib>
#include <string>

#include "s2nnds/core/check.h"

namespace s2nnds {

namespace plain {
extern const DenseKernels<float> float_kernels;
extern const DenseKernels<double> double_kernels;
}  // namespace plain
#if defined(__x86_64__)
namespace avx2 {
extern const DenseKernels<float> float_kernels;
extern const DenseKernels<double> double_kernels;
}  // namespace avx2
namespace avx512 {
extern const DenseKernels<float> float_kernels;
extern const DenseKernels<double> double_kernels;
}  // namespace avx512
#endif

namespace {

enum class InstructionSet { plain, avx2, avx512 };

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

InstructionSet chosen() {
  const InstructionSet best = best_of_this_processor();
  const char* wish = std::getenv("S2NNDS_ISA");
  if (wish == nullptr || *wish == '\0') return best;
  const std::string name = wish;
  if (name == "plain") return InstructionSet::plain;
  if (name == "avx2" && best >= InstructionSet::avx2) return InstructionSet::avx2;
  if (name == "avx512" && best >= InstructionSet::avx512) return InstructionSet::avx512;
  fail("S2NNDS_ISA: found \"{}\", expected plain, avx2 or avx512, and one that this processor has", name);
}

template <typename T>
const DenseKernels<T>& pick(const DenseKernels<T>& plain_set,
                            [[maybe_unused]] const DenseKernels<T>& avx2_set,
                            [[maybe_unused]] const DenseKernels<T>& avx512_set) {
  switch (chosen()) {
    case InstructionSet::avx512:
      return avx512_set;
    case InstructionSet::avx2:
      return avx2_set;
    case InstructionSet::plain:
      break;
  }
  return plain_set;
}

}  // namespace

#if defined(__x86_64__)
template <>
const DenseKernels<float>& dense_kernels<float>() {
  static const DenseKernels<float>& kernels =
      pick(plain::float_kernels, avx2::float_kernels, avx512::float_kernels);
  return kernels;
}
template <>
const DenseKernels<double>& dense_kernels<double>() {
  static const DenseKernels<double>& kernels =
      pick(plain::double_kernels, avx2::double_kernels, avx512::double_kernels);
  return kernels;
}
#else
template <>
const DenseKernels<float>& dense_kernels<float>() {
  return plain::float_kernels;
}
template <>
const DenseKernels<double>& dense_kernels<double>() {
  return plain::double_kernels;
}
#endif

}  // namespace s2nnds
