// SPDX-License-Identifier: BSD-3-Clause
// Prints digests of what the kernels without vector instructions compute from random numbers: the same on every
// processor (aarch64_kernels.sh).
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <vector>

#include "s2nnds/networks/dense_kernels.h"
#include "s2nnds/verification/taylor_kernels.h"

namespace s2nnds::plain {
extern const DenseKernels<float> float_kernels;
extern const DenseKernels<double> double_kernels;
extern const TaylorKernels taylor_kernels;
}  // namespace s2nnds::plain

namespace {

// Softplus and sine call the C library, whose last bits differ between processors.
constexpr std::array activations = {s2nnds::Activation::identity, s2nnds::Activation::tanh,
                                    s2nnds::Activation::elu, s2nnds::Activation::silu};

// FNV-1a.
class Digest {
 public:
  void add(const void* values, std::size_t bytes) {
    std::vector<unsigned char> copy(bytes);
    std::memcpy(copy.data(), values, bytes);
    for (const unsigned char byte : copy) value_ = (value_ ^ byte) * 1099511628211U;
  }
  template <typename T>
  void add(const std::vector<T>& values) {
    add(values.data(), values.size() * sizeof(T));
  }
  void print(const char* what) const {
    std::printf("%s %016llx\n", what, static_cast<unsigned long long>(value_));
  }

 private:
  std::uint64_t value_ = 14695981039346656037U;
};

// In [-4, 4), by a linear congruence.
double next_number() {
  static std::uint64_t state = 1;
  state = state * 6364136223846793005U + 1442695040888963407U;
  return static_cast<double>(state >> 11) * 0x1p-53 * 8.0 - 4.0;
}

template <typename T>
Digest dense(const s2nnds::DenseKernels<T>& kernels) {
  constexpr std::ptrdiff_t side = 48;
  constexpr std::ptrdiff_t count = side * side;
  Digest digest;
  for (int round = 0; round < 50; ++round) {
    std::vector<T> a(count), b(count), c(count), first(count), second(count);
    for (auto* const numbers : {&a, &b, &c}) {
      for (T& number : *numbers) number = static_cast<T>(next_number());
    }
    kernels.multiply(side, side, side, a.data(), side, 1, b.data(), side, c.data(), side, round % 2 == 0);
    digest.add(c);
    for (const s2nnds::Activation activation : activations) {
      kernels.activate(activation, count, b.data(), a.data(), first.data(), second.data());
      for (const auto* const numbers : {&a, &first, &second}) digest.add(*numbers);
    }
    kernels.push_tangent(count, first.data(), b.data(), a.data(), second.data());
    kernels.pull_adjoint(count, first.data(), second.data(), a.data(), b.data());
    for (const auto* const numbers : {&a, &b, &second}) digest.add(*numbers);
  }
  return digest;
}

Digest expansions() {
  Digest digest;
  for (int round = 0; round < 1000; ++round) {
    std::array<double, s2nnds::tile_boxes> center{}, radius{};
    for (double& number : center) number = next_number();
    for (double& number : radius) number = 0.01 * (4.0 + next_number());
    for (const s2nnds::Activation activation : activations) {
      s2nnds::ActivationExpansion expansion{};
      s2nnds::plain::taylor_kernels.expand(activation, center.data(), radius.data(), expansion);
      digest.add(&expansion, sizeof(expansion));
    }
  }
  return digest;
}

}  // namespace

int main() {
  dense(s2nnds::plain::float_kernels).print("float");
  dense(s2nnds::plain::double_kernels).print("double");
  expansions().print("proof");
}
