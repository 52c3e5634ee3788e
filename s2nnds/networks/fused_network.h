// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "s2nnds/networks/activation.h"
#include "s2nnds/networks/dense_kernels.h"
#include "s2nnds/networks/network_weights.h"

namespace s2nnds {

// The shape of one layer of a fully connected network.
struct LayerShape {
  std::ptrdiff_t inputs = 0;                     // numbers that it takes, > 0 in a network
  std::ptrdiff_t outputs = 0;                    // its neurons, > 0 in a network
  bool bias = true;                              // whether it adds a bias [outputs]
  Activation activation = Activation::identity;  // of all its neurons

  // Numbers in weight and bias.
  std::ptrdiff_t parameters() const { return outputs * inputs + (bias ? outputs : 0); }
};

// Memory aligned to cache lines, grown as needed and never initialised.
template <typename T>
class Buffer {
 public:
  Buffer() = default;
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  Buffer(Buffer&& other) noexcept { *this = std::move(other); }  // leaves `other` empty
  // Swaps the two.
  Buffer& operator=(Buffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  ~Buffer();
  T* reserve(std::size_t count);     // at least count elements; the old contents are lost when it grows
  T* data() const { return data_; }  // null before reserve()

 private:
  T* data_ = nullptr;
  std::size_t capacity_ = 0;
};

// N(x) of a fully connected network and its derivative along a direction, and, with FusedTile, the reverse
// sweep through both, tile by tile so that activations stay in cache. With
//   z = W a + b,  a' = sigma(z),  dz = W da,  da' = sigma'(z) dz,  and A, T the adjoints of a', da':
//   adj dz = T sigma'(z),  adj z = A sigma'(z) + T dz sigma''(z),  dW += adj_z a^T + adj_dz da^T.
// Rows are samples. Results do not depend on the number of threads.
template <typename T>
class FusedNetwork {
 public:
  // Samples of one tile: a multiple of the kernels' row blocks; fits in the L1 cache.
  static constexpr std::ptrdiff_t tile_rows = 48;

  // Throws Error if there is no layer or one does not fit the layer before. load() must follow.
  explicit FusedNetwork(std::vector<LayerShape> layers);

  std::ptrdiff_t inputs() const { return layers_.front().inputs; }   // of the first layer
  std::ptrdiff_t outputs() const { return layers_.back().outputs; }  // of the last layer
  std::ptrdiff_t parameters() const;                                 // numbers in all layers

  // Takes flat parameters: per layer the weight [out, in] row-major, then the bias [out] if it has one.
  void load(const T* parameters);

  // x [samples, inputs], value [samples, outputs]; if direction [samples, inputs] is not null, also
  // derivative [samples, outputs].
  void forward(std::ptrdiff_t samples, const T* x, const T* direction, T* value, T* derivative) const;

 private:
  template <typename>
  friend class FusedTile;

  struct Packed {
    LayerShape shape;
    std::ptrdiff_t in_width = 0, out_width = 0;          // padded
    std::ptrdiff_t transposed = 0, plain = 0, bias = 0;  // offsets into weights_
    std::ptrdiff_t parameter = 0;                        // offset of the weight among the flat parameters
    std::ptrdiff_t tape = 0;                             // offset, in units of samples, into the tape
  };

  // Of at most tile_rows samples. The tape, of FusedTile, may be null.
  void forward_tile(std::ptrdiff_t rows, const T* x, const T* direction, T* value, T* derivative, T* scratch,
                    T* tape) const;
  void backward_tile(std::ptrdiff_t rows, const T* x, const T* direction, const T* tape,
                     const T* adjoint_value, const T* adjoint_derivative, T* gradient, T* adjoint_direction,
                     T* scratch) const;
  void pull_back_tile(std::ptrdiff_t rows, const T* tape, const T* adjoint_value, T* adjoint_x,
                      T* scratch) const;
  void unpack_gradient(const T* packed, T* parameter_gradient) const;

  std::vector<LayerShape> layers_;
  std::vector<Packed> packed_;
  Buffer<T> weights_;
  std::ptrdiff_t weights_size_ = 0;
  std::ptrdiff_t widest_ = 0;
  std::ptrdiff_t tape_width_ = 0;  // elements per sample and stored quantity, over all layers
  std::ptrdiff_t gradient_size_ = 0;
};

// One tile of at most tile_rows samples forward and back, in memory of its own: a loss over several networks
// strings such tiles together while all of them are in cache. The gradient of the parameters adds up over the
// tiles. The network must outlive it; not to be shared by threads.
template <typename T>
class FusedTile {
 public:
  explicit FusedTile(const FusedNetwork<T>& network);  // with a gradient of 0

  // As FusedNetwork::forward for rows <= tile_rows; x and direction must live until backward.
  void forward(std::ptrdiff_t rows, const T* x, const T* direction, T* value, T* derivative);
  // Of the last forward: adds to the gradient and, unless null, writes the adjoint of the direction.
  void backward(const T* adjoint_value, const T* adjoint_derivative, T* adjoint_direction);

  // Of the last forward: J' adjoint [rows, inputs], J the Jacobian of the network's value, for adjoints
  // [rows, outputs]. Leaves the gradient alone.
  void pull_back(const T* adjoint_value, T* adjoint_x);

  void clear_gradient();  // sets it to 0
  // The gradient in the network's padded order, where gradients of several tiles may be added up.
  T* packed_gradient() { return gradient_.data(); }
  std::ptrdiff_t packed_size() const { return network_.gradient_size_; }  // elements of packed_gradient()
  // The gradient in the order of FusedNetwork::load: [parameters()].
  void unpack_gradient(T* parameter_gradient) const;

 private:
  const FusedNetwork<T>& network_;
  Buffer<T> scratch_, tape_, gradient_;
  std::ptrdiff_t rows_ = 0;
  const T* x_ = nullptr;
  const T* direction_ = nullptr;
};

}  // namespace s2nnds
