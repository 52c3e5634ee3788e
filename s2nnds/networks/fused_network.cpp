// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/fused_network.h"

#include <algorithm>
#include <cstdlib>
#include <new>

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"

namespace s2nnds {
namespace {

using std::ptrdiff_t;

constexpr ptrdiff_t kTileRows = FusedNetwork<float>::tile_rows;
// Memory of a tile's sweeps, in tiles of the widest layer.
constexpr ptrdiff_t kForwardScratch = 8, kBackwardScratch = 7;
constexpr ptrdiff_t kPartsPerThread = 4;  // of a forward sweep
constexpr ptrdiff_t kLeastParallelWork =
    1000000;  // products; less is done before a second thread has woken up
// The layers' values on the tape: activation, its tangent, sigma'(z), and dz sigma''(z).
constexpr int kTapeQuantities = 4;

}  // namespace

template <typename T>
Buffer<T>::~Buffer() {
  std::free(data_);
}

template <typename T>
T* Buffer<T>::reserve(std::size_t count) {
  if (count > capacity_) {
    std::free(data_);
    const std::size_t bytes = (count * sizeof(T) + 63) / 64 * 64;
    data_ = static_cast<T*>(std::aligned_alloc(64, bytes));
    capacity_ = data_ ? count : 0;
    if (!data_) throw std::bad_alloc();
  }
  return data_;
}

template <typename T>
FusedNetwork<T>::FusedNetwork(std::vector<LayerShape> layers) : layers_(std::move(layers)) {
  check(!layers_.empty(), "fused network: found no layers, expected at least one");
  ptrdiff_t parameter = 0;
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const LayerShape& shape = layers_[l];
    check(shape.inputs > 0 && shape.outputs > 0 && (l == 0 || shape.inputs == layers_[l - 1].outputs),
          "fused network: layer {} has {} inputs and {} outputs, which does not fit the layer before", l,
          shape.inputs, shape.outputs);
    Packed p;
    p.shape = shape;
    p.in_width = padded(shape.inputs);
    p.out_width = padded(shape.outputs);
    p.transposed = weights_size_;
    p.plain = p.transposed + shape.inputs * p.out_width;
    p.bias = p.plain + shape.outputs * p.in_width;
    weights_size_ = p.bias + p.out_width;
    p.parameter = parameter;
    parameter += shape.parameters();
    p.tape = tape_width_;
    tape_width_ += p.out_width;
    gradient_size_ += shape.outputs * p.in_width + p.out_width;
    widest_ = std::max({widest_, p.in_width, p.out_width});
    packed_.push_back(p);
  }
}

template <typename T>
ptrdiff_t FusedNetwork<T>::parameters() const {
  return packed_.back().parameter + packed_.back().shape.parameters();
}

template <typename T>
void FusedNetwork<T>::load(const T* parameters) {
  T* all = weights_.reserve(weights_size_);
  std::fill(all, all + weights_size_, T(0));
  for (const Packed& p : packed_) {
    const T* weight = parameters + p.parameter;
    for (ptrdiff_t o = 0; o < p.shape.outputs; ++o) {
      for (ptrdiff_t i = 0; i < p.shape.inputs; ++i) {
        all[p.transposed + i * p.out_width + o] = all[p.plain + o * p.in_width + i] =
            weight[o * p.shape.inputs + i];
      }
    }
    if (p.shape.bias) std::copy_n(weight + p.shape.outputs * p.shape.inputs, p.shape.outputs, all + p.bias);
  }
}

template <typename T>
void FusedNetwork<T>::forward_tile(ptrdiff_t rows, const T* x, const T* direction, T* value, T* derivative,
                                   T* scratch, T* tape) const {
  const DenseKernels<T>& kernels = dense_kernels<T>();
  const ptrdiff_t tile = kTileRows * widest_;
  T* z = scratch;
  T* dz = scratch + tile;
  T* slope = scratch + 2 * tile;
  T* curve = scratch + 3 * tile;
  T* buffers[2] = {scratch + 4 * tile, scratch + 6 * tile};
  const T* a = x;
  const T* da = direction;
  ptrdiff_t stride = inputs();
  for (std::size_t l = 0; l < packed_.size(); ++l) {
    const Packed& p = packed_[l];
    const T* weight = weights_.data() + p.transposed;
    const T* bias = weights_.data() + p.bias;
    const ptrdiff_t width = p.out_width, count = rows * width;
    for (ptrdiff_t s = 0; s < rows; ++s) std::copy_n(bias, width, z + s * width);
    kernels.multiply(rows, width, p.shape.inputs, a, stride, 1, weight, width, z, width, true);
    if (direction)
      kernels.multiply(rows, width, p.shape.inputs, da, stride, 1, weight, width, dz, width, false);

    T* next = buffers[l % 2];
    T* next_tangent = next + tile;
    T* first_derivative = slope;
    T* scaled_second = curve;
    if (tape) {
      const auto at = [&](int quantity) { return tape + (quantity * tape_width_ + p.tape) * kTileRows; };
      next = at(0);
      next_tangent = at(1);
      first_derivative = at(2);
      scaled_second = at(3);
    }
    const bool wants_slope = direction || tape;
    kernels.activate(p.shape.activation, count, z, next, wants_slope ? first_derivative : nullptr,
                     tape && direction ? scaled_second : nullptr);
    if (direction)
      kernels.push_tangent(count, first_derivative, dz, next_tangent, tape ? scaled_second : nullptr);
    a = next;
    da = next_tangent;
    stride = width;
  }
  const ptrdiff_t m = outputs();
  for (ptrdiff_t s = 0; s < rows; ++s) {
    std::copy_n(a + s * stride, m, value + s * m);
    if (direction) std::copy_n(da + s * stride, m, derivative + s * m);
  }
}

template <typename T>
void FusedNetwork<T>::forward(ptrdiff_t samples, const T* x, const T* direction, T* value,
                              T* derivative) const {
  const ptrdiff_t n = inputs(), m = outputs();
  const ptrdiff_t tiles = (samples + kTileRows - 1) / kTileRows;
  const auto run = [&](ptrdiff_t begin, ptrdiff_t end) {
    Buffer<T> scratch;
    scratch.reserve(kForwardScratch * kTileRows * widest_);
    for (ptrdiff_t t = begin; t < end; ++t) {
      const ptrdiff_t first = t * kTileRows, rows = std::min(kTileRows, samples - first);
      forward_tile(rows, x + first * n, direction ? direction + first * n : nullptr, value + first * m,
                   direction ? derivative + first * m : nullptr, scratch.data(), nullptr);
    }
  };
  if (samples * parameters() < kLeastParallelWork) return run(0, tiles);
  const ptrdiff_t parts = std::min(tiles, kPartsPerThread * static_cast<ptrdiff_t>(thread_count()));
  parallel_for(parts, [&](ptrdiff_t part, int) { run(tiles * part / parts, tiles * (part + 1) / parts); });
}

namespace {

// [rows, n] into rows of `width` columns, the rest zero.
template <typename T>
void pad(ptrdiff_t rows, ptrdiff_t n, const T* from, ptrdiff_t width, T* to) {
  std::fill(to, to + rows * width, T(0));
  for (ptrdiff_t s = 0; s < rows; ++s) std::copy_n(from + s * n, n, to + s * width);
}

}  // namespace

template <typename T>
void FusedNetwork<T>::backward_tile(ptrdiff_t rows, const T* x, const T* direction, const T* tape,
                                    const T* adjoint_value, const T* adjoint_derivative, T* gradient,
                                    T* adjoint_direction, T* scratch) const {
  const DenseKernels<T>& kernels = dense_kernels<T>();
  const ptrdiff_t tile = kTileRows * widest_;
  T* adjoint = scratch;                 // of z, before that of the activation
  T* adjoint_tangent = scratch + tile;  // of dz, and before that of da
  T* below = scratch + 2 * tile;
  T* below_tangent = scratch + 3 * tile;
  T* input = scratch + 4 * tile;
  T* input_tangent = scratch + 5 * tile;
  T* ones = scratch + 6 * tile;
  std::fill(ones, ones + rows, T(1));
  pad(rows, outputs(), adjoint_value, packed_.back().out_width, adjoint);
  pad(rows, inputs(), x, packed_.front().in_width, input);
  if (direction) {
    pad(rows, outputs(), adjoint_derivative, packed_.back().out_width, adjoint_tangent);
    pad(rows, inputs(), direction, packed_.front().in_width, input_tangent);
  }
  T* gradient_end = gradient + gradient_size_;
  for (std::size_t l = packed_.size(); l-- > 0;) {
    const Packed& p = packed_[l];
    const ptrdiff_t width = p.out_width, depth = p.shape.outputs;
    const auto at = [&](const Packed& layer, int quantity) {
      return tape + (quantity * tape_width_ + layer.tape) * kTileRows;
    };
    kernels.pull_adjoint(rows * width, at(p, 2), at(p, 3), adjoint, direction ? adjoint_tangent : nullptr);

    gradient_end -= depth * p.in_width + width;
    T* weight_gradient = gradient_end;
    T* bias_gradient = gradient_end + depth * p.in_width;
    kernels.multiply(1, width, rows, ones, 0, 1, adjoint, width, bias_gradient, width, true);
    const T* a = l > 0 ? at(packed_[l - 1], 0) : input;
    kernels.multiply(depth, p.in_width, rows, adjoint, 1, width, a, p.in_width, weight_gradient, p.in_width,
                     true);
    if (direction) {
      const T* da = l > 0 ? at(packed_[l - 1], 1) : input_tangent;
      kernels.multiply(depth, p.in_width, rows, adjoint_tangent, 1, width, da, p.in_width, weight_gradient,
                       p.in_width, true);
    }
    const T* weight = weights_.data() + p.plain;
    if (l > 0) {
      kernels.multiply(rows, p.in_width, depth, adjoint, width, 1, weight, p.in_width, below, p.in_width,
                       false);
    }
    if (direction && (l > 0 || adjoint_direction)) {
      kernels.multiply(rows, p.in_width, depth, adjoint_tangent, width, 1, weight, p.in_width, below_tangent,
                       p.in_width, false);
    }
    std::swap(adjoint, below);
    std::swap(adjoint_tangent, below_tangent);
  }
  if (!adjoint_direction) return;
  const ptrdiff_t n = inputs(), width = packed_.front().in_width;
  for (ptrdiff_t s = 0; s < rows; ++s) std::copy_n(adjoint_tangent + s * width, n, adjoint_direction + s * n);
}

template <typename T>
void FusedNetwork<T>::pull_back_tile(ptrdiff_t rows, const T* tape, const T* adjoint_value, T* adjoint_x,
                                     T* scratch) const {
  const DenseKernels<T>& kernels = dense_kernels<T>();
  T* adjoint = scratch;
  T* below = scratch + kTileRows * widest_;
  pad(rows, outputs(), adjoint_value, packed_.back().out_width, adjoint);
  for (std::size_t l = packed_.size(); l-- > 0;) {
    const Packed& p = packed_[l];
    const T* slope = tape + (2 * tape_width_ + p.tape) * kTileRows;
    kernels.pull_adjoint(rows * p.out_width, slope, nullptr, adjoint, nullptr);
    kernels.multiply(rows, p.in_width, p.shape.outputs, adjoint, p.out_width, 1, weights_.data() + p.plain,
                     p.in_width, below, p.in_width, false);
    std::swap(adjoint, below);
  }
  const ptrdiff_t n = inputs(), width = packed_.front().in_width;
  for (ptrdiff_t s = 0; s < rows; ++s) std::copy_n(adjoint + s * width, n, adjoint_x + s * n);
}

template <typename T>
void FusedNetwork<T>::unpack_gradient(const T* packed, T* parameter_gradient) const {
  for (const Packed& p : packed_) {
    T* to = parameter_gradient + p.parameter;
    for (ptrdiff_t o = 0; o < p.shape.outputs; ++o) {
      std::copy_n(packed + o * p.in_width, p.shape.inputs, to + o * p.shape.inputs);
    }
    packed += p.shape.outputs * p.in_width;
    if (p.shape.bias) std::copy_n(packed, p.shape.outputs, to + p.shape.outputs * p.shape.inputs);
    packed += p.out_width;
  }
}

template <typename T>
FusedTile<T>::FusedTile(const FusedNetwork<T>& network) : network_(network) {
  scratch_.reserve(std::max(kForwardScratch, kBackwardScratch) * kTileRows * network.widest_);
  tape_.reserve(kTapeQuantities * network.tape_width_ * kTileRows);
  gradient_.reserve(network.gradient_size_);
  clear_gradient();
}

template <typename T>
void FusedTile<T>::clear_gradient() {
  std::fill_n(gradient_.data(), network_.gradient_size_, T(0));
}

template <typename T>
void FusedTile<T>::forward(ptrdiff_t rows, const T* x, const T* direction, T* value, T* derivative) {
  rows_ = rows;
  x_ = x;
  direction_ = direction;
  network_.forward_tile(rows, x, direction, value, derivative, scratch_.data(), tape_.data());
}

template <typename T>
void FusedTile<T>::backward(const T* adjoint_value, const T* adjoint_derivative, T* adjoint_direction) {
  network_.backward_tile(rows_, x_, direction_, tape_.data(), adjoint_value, adjoint_derivative,
                         gradient_.data(), direction_ ? adjoint_direction : nullptr, scratch_.data());
}

template <typename T>
void FusedTile<T>::pull_back(const T* adjoint_value, T* adjoint_x) {
  network_.pull_back_tile(rows_, tape_.data(), adjoint_value, adjoint_x, scratch_.data());
}

template <typename T>
void FusedTile<T>::unpack_gradient(T* parameter_gradient) const {
  network_.unpack_gradient(gradient_.data(), parameter_gradient);
}

template class Buffer<float>;
template class Buffer<double>;
template class FusedNetwork<float>;
template class FusedNetwork<double>;
template class FusedTile<float>;
template class FusedTile<double>;

}  // namespace s2nnds
