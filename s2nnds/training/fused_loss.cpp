// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/training/fused_loss.h"

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include <algorithm>
#include <cmath>

#include "s2nnds/conditions/worst_perturbation.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/networks/dynamics.h"

namespace s2nnds {
namespace {

using std::ptrdiff_t;

constexpr ptrdiff_t kChunks = 4;            // the most threads that can share a step
constexpr double kLeastParallelWork = 1e6;  // products; less is done before a second thread has woken up

// Numbers below the least normal float count as zero in this thread. Losses without a lower bound drive
// activations into saturation, whose gradients are such numbers, and the processor takes 100 times as long
// for them.
class FlushSubnormals {
 public:
#ifdef __SSE2__
  FlushSubnormals() { _mm_setcsr(before_ | kFlushToZero | kSubnormalsAreZero); }
  ~FlushSubnormals() { _mm_setcsr(before_); }
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
  static constexpr unsigned kFlushToZero = 0x8000, kSubnormalsAreZero = 0x0040;
  unsigned before_ = _mm_getcsr();
#endif
};

}  // namespace

// What one thread at a time works with.
template <typename T>
struct FusedLoss<T>::Chunk {
  Chunk(const FusedNetwork<T>& network_f, const FusedNetwork<T>& network_V, const FusedNetwork<T>& network_B)
      : f(network_f), V(network_V), B(network_B) {
    constexpr auto rows = static_cast<std::size_t>(FusedNetwork<T>::tile_rows);
    const auto n = static_cast<std::size_t>(network_f.inputs()),
               m = static_cast<std::size_t>(network_V.outputs());
    for (auto* of_f : {&velocity, &velocity_adjoint, &part, &axis, &gradient, &direction_V, &direction_B})
      of_f->resize(rows * n);
    jacobian.resize(rows * n * n);
    for (auto* of_V : {&features, &tangent, &features_adjoint, &tangent_adjoint}) of_V->resize(rows * m);
    for (auto* of_B : {&barrier, &barrier_dot, &barrier_adjoint, &barrier_dot_adjoint}) of_B->resize(rows);
    for (auto* scalar : {&values, &adjoints}) scalar->resize(4 * rows);
    f_origin_adjoint.resize(n);
    V_origin_adjoint.resize(m);
  }

  void clear() {
    f.clear_gradient();
    V.clear_gradient();
    B.clear_gradient();
    std::fill(f_origin_adjoint.begin(), f_origin_adjoint.end(), T(0));
    std::fill(V_origin_adjoint.begin(), V_origin_adjoint.end(), T(0));
    sums = {};
    work.clear();
    cost = 0.0;
  }

  // The k-th of V, Vdot, B, Bdot [rows].
  double* value(ptrdiff_t k) { return values.data() + k * FusedNetwork<T>::tile_rows; }
  double* adjoint(ptrdiff_t k) { return adjoints.data() + k * FusedNetwork<T>::tile_rows; }

  FusedTile<T> f, V, B;
  std::vector<T> velocity, velocity_adjoint, part;                      // [rows, n]
  std::vector<T> axis, gradient, direction_V, direction_B;              // [rows, n], for perturbed motions
  std::vector<T> jacobian;                                              // [rows, n, n]
  std::vector<T> features, tangent, features_adjoint, tangent_adjoint;  // [rows, features]
  std::vector<T> barrier, barrier_dot, barrier_adjoint, barrier_dot_adjoint;  // [rows]
  std::vector<double> values, adjoints;                                       // [4, rows]
  std::vector<T> f_origin_adjoint, V_origin_adjoint;                          // of N(0)
  PerTerm<double> sums{};
  std::vector<Work> work;
  double cost = 0.0;
};

template <typename T>
FusedLoss<T>::FusedLoss(const NetworkShape& f, const NetworkShape& V, const NetworkShape& B,
                        const LossTable& table, const LossOptions& options, const Trains& trains)
    : shape_f_(f), shape_V_(V), options_(options), trains_(trains), f_(f.layers), V_(V.layers), B_(B.layers) {
  dimension_ = f_.inputs();
  check(f_.outputs() == dimension_ && V_.inputs() == dimension_ && B_.inputs() == dimension_ &&
            B_.outputs() == 1,
        "fused loss: f has {} inputs and {} outputs, V {} inputs, B {} inputs and {} outputs, expected n, "
        "n, n, n, 1",
        f_.inputs(), f_.outputs(), V_.inputs(), B_.inputs(), B_.outputs());
  check(!is_sum_of_squares(f.head) && V.head != Head::zero_at_origin && B.head == Head::plain &&
            (is_sum_of_squares(V.head) || V_.outputs() == 1) &&
            (V.head != Head::diffeomorphism || V_.outputs() == dimension_),
        "fused loss: found heads {}, {}, {}, expected zero_at_origin or plain, a sum of squares or plain, "
        "plain",
        to_string(f.head), to_string(V.head), to_string(B.head));
  check(options.projection == 0.0 || (V.head == Head::diffeomorphism && !options.execution.asks_of_barrier()),
        "fused loss: found a projected f with a V that is no diffeomorphism, or with an execution model");
  const auto products = [](const FusedNetwork<T>& network) {
    return static_cast<double>(network.parameters());
  };
  for (const Samples set : all_samples) {
    Pass& pass = passes_[static_cast<std::size_t>(set)];
    Quantities all;  // tiles are shared out alike, whichever terms weigh nothing in a round
    for (const LossPart& part : table) {
      if (part.samples != set) continue;
      all = all | part.needs;
      if (!applies(part, options, trains)) continue;
      pass.parts.push_back(part);
      pass.needs = pass.needs | part.needs;
    }
    if (all.any_f()) pass.cost += 3.0 * products(f_);
    if (all.any_V()) pass.cost += (all.V_dot ? 6.0 : 3.0) * products(V_);
    if (all.any_B()) pass.cost += (all.B_dot ? 6.0 : 3.0) * products(B_);
  }
  origin_.resize(dimension_);
  f_at_origin_.resize(f_.outputs());
  V_at_origin_.resize(V_.outputs());
  for (ptrdiff_t c = 0; c < kChunks; ++c) chunks_.push_back(std::make_unique<Chunk>(f_, V_, B_));
}

template <typename T>
FusedLoss<T>::~FusedLoss() = default;

// Tiles go, the costliest first, to the chunk with the least to do so far.
template <typename T>
void FusedLoss<T>::share_out(const BatchView<T>& batch) {
  std::vector<Work> all;
  for (const Samples set : all_samples) {
    const Pass& pass = passes_[static_cast<std::size_t>(set)];
    if (pass.parts.empty()) continue;
    const ptrdiff_t count = batch.points(set).count;
    for (ptrdiff_t first = 0; first < count; first += FusedNetwork<T>::tile_rows) {
      const ptrdiff_t rows = std::min(FusedNetwork<T>::tile_rows, count - first);
      all.push_back({set, first, rows, pass.cost * static_cast<double>(rows)});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const Work& a, const Work& b) { return a.cost > b.cost; });
  for (const Work& work : all) {
    const auto least = std::min_element(chunks_.begin(), chunks_.end(),
                                        [](const auto& a, const auto& b) { return a->cost < b->cost; });
    (*least)->work.push_back(work);
    (*least)->cost += work.cost;
  }
}

template <typename T>
void FusedLoss<T>::take_origins() {
  if (shape_f_.head == Head::zero_at_origin)
    f_.forward(1, origin_.data(), nullptr, f_at_origin_.data(), nullptr);
  if (shape_V_.head != Head::plain) V_.forward(1, origin_.data(), nullptr, V_at_origin_.data(), nullptr);
}

// Calls visit(k, e_k) with e_k [rows, n] for each axis.
template <typename T, typename Visit>
void for_axes(std::vector<T>& axis, ptrdiff_t n, ptrdiff_t rows, const Visit& visit) {
  for (ptrdiff_t k = 0; k < n; ++k) {
    for (ptrdiff_t i = 0; i < rows * n; ++i) axis[i] = i % n == k ? T(1) : T(0);
    visit(k, axis.data());
  }
}

template <typename T>
void FusedLoss<T>::take_jacobian(Chunk& chunk, const Quantities& needs, const T* x, ptrdiff_t rows) const {
  const bool counts = (needs.V_dot && options_.execution.asks_of_lyapunov()) ||
                      (needs.B_dot && options_.execution.asks_of_barrier());
  if (!counts || !options_.execution.model.displaces()) return;
  const ptrdiff_t n = dimension_;
  for_axes(chunk.axis, n, rows, [&](ptrdiff_t k, const T* axis) {
    chunk.f.forward(rows, x, axis, chunk.velocity.data(), chunk.part.data());
    for (ptrdiff_t i = 0; i < rows * n; ++i) chunk.jacobian[i * n + k] = chunk.part[i];
  });
}

// From chunk.gradient.
template <typename T>
void FusedLoss<T>::perturb(Chunk& chunk, ptrdiff_t rows, std::vector<T>& directions) const {
  const ptrdiff_t n = dimension_;
  for (ptrdiff_t s = 0; s < rows; ++s) {
    T* direction = directions.data() + s * n;
    const T* velocity = chunk.velocity.data() + s * n;
    worst_perturbation(options_.execution.model, n, chunk.gradient.data() + s * n, velocity,
                       chunk.jacobian.data() + s * n * n, direction);
    for (ptrdiff_t k = 0; k < n; ++k) direction[k] += velocity[k];
  }
}

template <typename T>
const T* FusedLoss<T>::direction_of_V(Chunk& chunk, const Quantities& needs, const T* x,
                                      ptrdiff_t rows) const {
  if (!needs.V_dot) return nullptr;
  if (!options_.execution.asks_of_lyapunov()) return chunk.velocity.data();
  const ptrdiff_t n = dimension_;
  for_axes(chunk.axis, n, rows, [&](ptrdiff_t k, const T* axis) {
    chunk.V.forward(rows, x, axis, chunk.features.data(), chunk.tangent.data());
    finish_V(chunk, true, x, axis, rows);
    for (ptrdiff_t s = 0; s < rows; ++s) chunk.gradient[s * n + k] = static_cast<T>(chunk.value(1)[s]);
  });
  perturb(chunk, rows, chunk.direction_V);
  for (ptrdiff_t s = 0; s < rows; ++s) {
    double squared = 0.0;
    for (ptrdiff_t k = 0; k < n; ++k) squared += static_cast<double>(x[s * n + k]) * x[s * n + k];
    if (!(std::sqrt(squared) > options_.execution.convergence_radius))
      std::copy_n(chunk.velocity.data() + s * n, n, chunk.direction_V.data() + s * n);
  }
  return chunk.direction_V.data();
}

template <typename T>
const T* FusedLoss<T>::projected_velocity(Chunk& chunk, const Quantities& needs, const T* x,
                                          ptrdiff_t rows) const {
  const ptrdiff_t n = dimension_;
  if (!needs.any_V()) {
    chunk.V.forward(rows, x, nullptr, chunk.features.data(), nullptr);
    finish_V(chunk, false, x, nullptr, rows);
  }
  // grad |phi|^2 = 2 (I + J)' phi, J the Jacobian of V's layers.
  chunk.V.pull_back(chunk.features.data(), chunk.gradient.data());
  for (ptrdiff_t i = 0; i < rows * n; ++i) {
    chunk.gradient[i] = T(2) * (chunk.gradient[i] + chunk.features[i]);
    chunk.direction_B[i] = chunk.velocity[i];
  }
  for (ptrdiff_t s = 0; s < rows; ++s)
    project_velocity(n, chunk.gradient.data() + s * n, chunk.value(0)[s], options_.projection,
                     chunk.direction_B.data() + s * n);
  return chunk.direction_B.data();
}

template <typename T>
const T* FusedLoss<T>::direction_of_B(Chunk& chunk, const Quantities& needs, const T* x,
                                      ptrdiff_t rows) const {
  if (!needs.B_dot) return nullptr;
  if (options_.projection > 0.0) return projected_velocity(chunk, needs, x, rows);
  if (!options_.execution.asks_of_barrier()) return chunk.velocity.data();
  const ptrdiff_t n = dimension_;
  for_axes(chunk.axis, n, rows, [&](ptrdiff_t k, const T* axis) {
    chunk.B.forward(rows, x, axis, chunk.barrier.data(), chunk.barrier_dot.data());
    for (ptrdiff_t s = 0; s < rows; ++s) chunk.gradient[s * n + k] = chunk.barrier_dot[s];
  });
  perturb(chunk, rows, chunk.direction_B);
  return chunk.direction_B.data();
}

// V and Vdot, along `direction`, from the network's outputs, by V's head.
template <typename T>
void FusedLoss<T>::finish_V(Chunk& chunk, bool wants_V_dot, const T* x, const T* direction,
                            ptrdiff_t rows) const {
  const ptrdiff_t n = dimension_, m = V_.outputs();
  const bool squared = is_sum_of_squares(shape_V_.head), adds_x = shape_V_.head == Head::diffeomorphism;
  for (ptrdiff_t s = 0; s < rows; ++s) {
    T* feature = chunk.features.data() + s * m;
    T* tangent = chunk.tangent.data() + s * m;
    double V = squared ? 0.0 : static_cast<double>(feature[0]), V_dot = 0.0;
    if (squared) {
      for (ptrdiff_t j = 0; j < m; ++j) {
        feature[j] -= V_at_origin_[j];
        if (adds_x) feature[j] += x[s * n + j];
        if (adds_x && wants_V_dot) tangent[j] += direction[s * n + j];
        V += static_cast<double>(feature[j]) * static_cast<double>(feature[j]);
      }
      for (ptrdiff_t k = 0; k < n; ++k) {
        const double point = x[s * n + k];
        V += shape_V_.quadratic * point * point;
      }
    }
    if (wants_V_dot && squared) {
      for (ptrdiff_t j = 0; j < m; ++j)
        V_dot += 2.0 * static_cast<double>(feature[j]) * static_cast<double>(tangent[j]);
      for (ptrdiff_t k = 0; k < n; ++k) {
        const double point = x[s * n + k];
        V_dot += 2.0 * shape_V_.quadratic * point * static_cast<double>(direction[s * n + k]);
      }
    } else if (wants_V_dot) {
      V_dot = tangent[0];
    }
    chunk.value(0)[s] = V;
    chunk.value(1)[s] = V_dot;
  }
}

// The adjoints of the network's outputs from those of V and Vdot.
template <typename T>
void FusedLoss<T>::start_back_V(Chunk& chunk, const Quantities& needs, ptrdiff_t rows) const {
  const ptrdiff_t m = V_.outputs();
  for (ptrdiff_t s = 0; s < rows; ++s) {
    const double by_V = chunk.adjoint(0)[s], by_V_dot = chunk.adjoint(1)[s];
    const T* feature = chunk.features.data() + s * m;
    const T* tangent = chunk.tangent.data() + s * m;
    T* feature_adjoint = chunk.features_adjoint.data() + s * m;
    T* tangent_adjoint = chunk.tangent_adjoint.data() + s * m;
    if (!is_sum_of_squares(shape_V_.head)) {
      feature_adjoint[0] = static_cast<T>(by_V);
      tangent_adjoint[0] = static_cast<T>(by_V_dot);
      continue;
    }
    for (ptrdiff_t j = 0; j < m; ++j) {
      feature_adjoint[j] = static_cast<T>(2.0 * by_V) * feature[j];
      if (needs.V_dot) feature_adjoint[j] += static_cast<T>(2.0 * by_V_dot) * tangent[j];
      tangent_adjoint[j] = static_cast<T>(2.0 * by_V_dot) * feature[j];
      chunk.V_origin_adjoint[j] -= feature_adjoint[j];
    }
  }
}

template <typename T>
void FusedLoss<T>::run_tile(Chunk& chunk, const Work& work, const BatchView<T>& batch) const {
  const Pass& pass = passes_[static_cast<std::size_t>(work.set)];
  const Quantities& needs = pass.needs;
  const ptrdiff_t n = dimension_, rows = work.rows;
  const T* x = batch.points(work.set).data + work.first * n;
  const T* beside = batch.beside(work.set).data;
  T* velocity = chunk.velocity.data();
  take_jacobian(chunk, needs, x, rows);
  if (needs.any_f()) {
    chunk.f.forward(rows, x, nullptr, velocity, nullptr);
    for (ptrdiff_t i = 0; i < rows * n; ++i) velocity[i] -= f_at_origin_[i % n];
  }
  if (needs.any_V()) {
    const T* direction = direction_of_V(chunk, needs, x, rows);
    chunk.V.forward(rows, x, direction, chunk.features.data(), chunk.tangent.data());
    finish_V(chunk, needs.V_dot, x, direction, rows);
  }
  if (needs.any_B()) {
    const T* direction = direction_of_B(chunk, needs, x, rows);
    chunk.B.forward(rows, x, direction, chunk.barrier.data(), chunk.barrier_dot.data());
    std::copy_n(chunk.barrier.begin(), rows, chunk.value(2));
    if (needs.B_dot) std::copy_n(chunk.barrier_dot.begin(), rows, chunk.value(3));
  }

  T* velocity_adjoint = chunk.velocity_adjoint.data();
  std::fill_n(velocity_adjoint, rows * n, T(0));
  std::fill(chunk.adjoints.begin(), chunk.adjoints.end(), 0.0);
  const Tile<T> tile{rows,
                     n,
                     velocity,
                     beside ? beside + work.first * n : nullptr,
                     velocity_adjoint,
                     chunk.value(0),
                     chunk.value(1),
                     chunk.value(2),
                     chunk.value(3),
                     chunk.adjoint(0),
                     chunk.adjoint(1),
                     chunk.adjoint(2),
                     chunk.adjoint(3)};
  for (const LossPart& part : pass.parts) {
    const double weight =
        options_.weight[part.term] * (1.0 / static_cast<double>(batch.points(work.set).count));
    if constexpr (std::is_same_v<T, float>) {
      chunk.sums[part.term] += weight * part.sum_float(options_, weight, tile);
    } else {
      chunk.sums[part.term] += weight * part.sum_double(options_, weight, tile);
    }
  }

  T* along = trains_.f ? chunk.part.data() : nullptr;
  const auto add_part = [&] {
    for (ptrdiff_t i = 0; i < rows * n; ++i) velocity_adjoint[i] += along[i];
  };
  if (needs.any_V() && trains_.V) {
    start_back_V(chunk, needs, rows);
    chunk.V.backward(chunk.features_adjoint.data(), chunk.tangent_adjoint.data(), along);
    if (needs.V_dot && along) {
      for (ptrdiff_t i = 0; i < rows * n; ++i)
        velocity_adjoint[i] += static_cast<T>(2.0 * shape_V_.quadratic * chunk.adjoint(1)[i / n]) * x[i];
      add_part();
      for (ptrdiff_t i = 0; i < rows * n && shape_V_.head == Head::diffeomorphism; ++i)
        velocity_adjoint[i] += chunk.tangent_adjoint[i];
    }
  }
  if (needs.any_B() && trains_.B) {
    std::transform(chunk.adjoint(2), chunk.adjoint(2) + rows, chunk.barrier_adjoint.begin(),
                   [](double by) { return static_cast<T>(by); });
    std::transform(chunk.adjoint(3), chunk.adjoint(3) + rows, chunk.barrier_dot_adjoint.begin(),
                   [](double by) { return static_cast<T>(by); });
    chunk.B.backward(chunk.barrier_adjoint.data(), chunk.barrier_dot_adjoint.data(), along);
    if (needs.B_dot && along) add_part();
  }
  if (!needs.any_f() || !trains_.f) return;
  for (ptrdiff_t i = 0; i < rows * n; ++i) chunk.f_origin_adjoint[i % n] -= velocity_adjoint[i];
  chunk.f.backward(velocity_adjoint, nullptr, nullptr);
}

// N(0) enters every sample: its adjoints add up, and it goes back once.
template <typename T>
void FusedLoss<T>::run_origins() {
  Chunk& chunk = *chunks_.front();
  const auto go_back = [&](FusedTile<T>& tile, std::vector<T> Chunk::*adjoint, std::vector<T>& value) {
    for (std::size_t c = 1; c < chunks_.size(); ++c) {
      for (std::size_t j = 0; j < (chunk.*adjoint).size(); ++j)
        (chunk.*adjoint)[j] += (*chunks_[c].*adjoint)[j];
    }
    tile.forward(1, origin_.data(), nullptr, value.data(), nullptr);
    tile.backward((chunk.*adjoint).data(), nullptr, nullptr);
  };
  if (trains_.f && shape_f_.head == Head::zero_at_origin)
    go_back(chunk.f, &Chunk::f_origin_adjoint, f_at_origin_);
  if (trains_.V && is_sum_of_squares(shape_V_.head)) go_back(chunk.V, &Chunk::V_origin_adjoint, V_at_origin_);
}

template <typename T>
PerTerm<double> FusedLoss<T>::run(const T* theta_f, const T* theta_V, const T* theta_B,
                                  const BatchView<T>& batch, T* gradient_f, T* gradient_V, T* gradient_B) {
  f_.load(theta_f);
  V_.load(theta_V);
  B_.load(theta_B);
  take_origins();
  for (auto& chunk : chunks_) chunk->clear();
  share_out(batch);
  double cost = 0.0;
  for (const auto& chunk : chunks_) cost += chunk->cost;
  const auto run_chunk = [&](ptrdiff_t c, int) {
    [[maybe_unused]] const FlushSubnormals flush;
    Chunk& chunk = *chunks_[c];
    for (const Work& work : chunk.work) run_tile(chunk, work, batch);
  };
  if (cost < kLeastParallelWork) {
    for (ptrdiff_t c = 0; c < kChunks; ++c) run_chunk(c, 0);
  } else {
    parallel_for(kChunks, run_chunk);
  }
  run_origins();

  PerTerm<double> sums{};
  for (const auto& chunk : chunks_) {
    for (const LossTerm term : all_loss_terms) sums[term] += chunk->sums[term];
  }
  const auto add_up = [&](FusedTile<T> Chunk::*network, T* gradient) {
    FusedTile<T>& total = *chunks_.front().*network;
    for (std::size_t c = 1; c < chunks_.size(); ++c) {
      const T* more = (*chunks_[c].*network).packed_gradient();
      T* sum = total.packed_gradient();
      for (ptrdiff_t i = 0; i < total.packed_size(); ++i) sum[i] += more[i];
    }
    total.unpack_gradient(gradient);
  };
  add_up(&Chunk::f, gradient_f);
  add_up(&Chunk::V, gradient_V);
  add_up(&Chunk::B, gradient_B);
  return sums;
}

template class FusedLoss<float>;
template class FusedLoss<double>;

}  // namespace s2nnds
