// SPDX-License-Identifier: BSD-3-Clause
// How fast this machine multiplies matrices [1024, 1024]: the fastest of the libraries found at run time
// (OpenBLAS, by $S2NNDS_OPENBLAS or its name; oneDNN, which LibTorch brings) and Eigen compiled for this
// processor. A program of its own, so that Eigen for this processor never meets the library's. Prints one
// JSON object. Usage: gemm_rate [THREADS]
#include <dlfcn.h>
#include <omp.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace {

constexpr int kSize = 1024;
constexpr int kRepeats = 9;

struct GemmRate {
  double gflops = 0.0;  // median
  std::string library;
};

template <typename T>
using Square = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
template <typename T>
using Product = std::function<void(const Square<T>& a, const Square<T>& b, Square<T>& c)>;

template <typename Function>
Function* find_in(void* library, const char* name) {
  return library ? reinterpret_cast<Function*>(::dlsym(library, name)) : nullptr;
}

template <typename T>
using Cblas = void(int, int, int, int, int, int, T, const T*, int, const T*, int, T, T*, int);

template <typename T>
Product<T> openblas(int threads) {
  const char* wish = std::getenv("S2NNDS_OPENBLAS");
  void* library = ::dlopen(wish ? wish : "libopenblas.so.0", RTLD_NOW);
  auto* multiply = find_in<Cblas<T>>(library, sizeof(T) == 4 ? "cblas_sgemm" : "cblas_dgemm");
  if (auto* set = find_in<void(int)>(library, "openblas_set_num_threads")) set(threads);
  if (!multiply) return nullptr;
  return [multiply](const Square<T>& a, const Square<T>& b, Square<T>& c) {
    constexpr int column_major = 102, as_is = 111;
    multiply(column_major, as_is, as_is, kSize, kSize, kSize, T(1), a.data(), kSize, b.data(), kSize, T(0),
             c.data(), kSize);
  };
}

// oneDNN multiplies in single precision only. It is row-major, which for squares changes nothing.
Product<float> onednn() {
  using Sgemm = int(char, char, std::int64_t, std::int64_t, std::int64_t, float, const float*, std::int64_t,
                    const float*, std::int64_t, float, float*, std::int64_t);
  auto* multiply = find_in<Sgemm>(::dlopen("libdnnl.so.2", RTLD_NOW), "dnnl_sgemm");
  if (!multiply) return nullptr;
  return [multiply](const Square<float>& a, const Square<float>& b, Square<float>& c) {
    multiply('N', 'N', kSize, kSize, kSize, 1.0F, a.data(), kSize, b.data(), kSize, 0.0F, c.data(), kSize);
  };
}

template <typename T>
double gflops(const Product<T>& multiply) {
  const Square<T> a = Square<T>::Random(kSize, kSize), b = Square<T>::Random(kSize, kSize);
  Square<T> c = Square<T>::Zero(kSize, kSize);
  multiply(a, b, c);
  std::vector<double> seconds;
  for (int i = 0; i < kRepeats; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    multiply(a, b, c);
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  std::nth_element(seconds.begin(), seconds.begin() + kRepeats / 2, seconds.end());
  return 2e-9 * kSize * kSize * kSize / seconds[kRepeats / 2];
}

template <typename T>
void keep_faster(GemmRate& rate, const char* library, const Product<T>& multiply) {
  if (!multiply) return;
  const double found = gflops(multiply);
  if (found > rate.gflops) rate = {found, library};
}

template <typename T>
GemmRate fastest(int threads) {
  omp_set_num_threads(threads);
  Eigen::setNbThreads(threads);
  GemmRate rate;
  keep_faster<T>(rate, "Eigen",
                 [](const Square<T>& a, const Square<T>& b, Square<T>& c) { c.noalias() = a * b; });
  keep_faster<T>(rate, "OpenBLAS", openblas<T>(threads));
  if constexpr (sizeof(T) == 4) keep_faster<T>(rate, "oneDNN", onednn());
  return rate;
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : omp_get_max_threads();
  const GemmRate single = fastest<float>(threads), twice = fastest<double>(threads);
  std::printf(
      "{\"threads\": %d, \"sgemm_gflops\": %.2f, \"sgemm_library\": \"%s\", \"dgemm_gflops\": %.2f, "
      "\"dgemm_library\": \"%s\"}\n",
      threads, single.gflops, single.library.c_str(), twice.gflops, twice.library.c_str());
  return 0;
}
