#include "s2nnds/training/fused_loss.h"

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include <algorithm>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"

namespace s2nnds {
namespace {

using std::ptrdiff_t;

constexpr ptrdiff_t kChunks = 4;            // the most threads that can share a step
constexpr double kLeastParallelWork = 1e6;  // products; less is done before a second thread has woken up

// relu(z) or, with a leak, the paper's leaky ReLU, and its derivative. Comparisons are written so that NaN
// goes through and ends the training, instead of looking like a condition that is met.
struct Penalty {
  double value, slope;
};
Penalty rectify(double z, double leak) { return z <= 0.0 ? Penalty{leak * z, leak} : Penalty{z, 1.0}; }

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

// A tile of samples and what is to be done with it.
template <typename T>
struct FusedLoss<T>::Work {
  enum class Kind { demonstrations, boundary, workspace, region } kind;
  const T* points;
  ptrdiff_t first, rows;
  // Of a region: weight times the mean of the penalty of sign * B + margin, towards which term.
  double weight = 0.0, sign = 1.0, margin = 0.0;
  LossTerm term = LossTerm::barrier_sets;
  double cost = 0.0;
};

// What one thread at a time works with.
template <typename T>
struct FusedLoss<T>::Chunk {
  Chunk(const FusedNetwork<T>& network_f, const FusedNetwork<T>& network_V, const FusedNetwork<T>& network_B)
      : f(network_f), V(network_V), B(network_B) {
    constexpr auto rows = static_cast<std::size_t>(FusedNetwork<T>::tile_rows);
    const auto n = static_cast<std::size_t>(network_f.inputs()),
               m = static_cast<std::size_t>(network_V.outputs());
    for (auto* of_f : {&velocity, &velocity_adjoint, &part}) of_f->resize(rows * n);
    for (auto* of_V : {&features, &tangent, &features_adjoint, &tangent_adjoint}) of_V->resize(rows * m);
    for (auto* of_B : {&barrier, &barrier_dot, &barrier_adjoint, &barrier_dot_adjoint}) of_B->resize(rows);
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

  FusedTile<T> f, V, B;
  std::vector<T> velocity, velocity_adjoint, part;                      // [rows, n]
  std::vector<T> features, tangent, features_adjoint, tangent_adjoint;  // [rows, features]
  std::vector<T> barrier, barrier_dot, barrier_adjoint, barrier_dot_adjoint;
  std::vector<T> f_origin_adjoint, V_origin_adjoint;  // of N(0)
  PerTerm<double> sums{};
  std::vector<Work> work;
  double cost = 0.0;
};

template <typename T>
FusedLoss<T>::FusedLoss(const NetworkShape& f, const NetworkShape& V, const NetworkShape& B,
                        const LossOptions& options, Trains trains)
    : shape_f_(f), shape_V_(V), options_(options), trains_(trains), f_(f.layers), V_(V.layers), B_(B.layers) {
  dimension_ = f_.inputs();
  check(f_.outputs() == dimension_ && V_.inputs() == dimension_ && B_.inputs() == dimension_ &&
            B_.outputs() == 1,
        "fused loss: f has {} inputs and {} outputs, V {} inputs, B {} inputs and {} outputs, expected n, "
        "n, n, n, 1",
        f_.inputs(), f_.outputs(), V_.inputs(), B_.inputs(), B_.outputs());
  check(f.head != Head::squared_norm && V.head != Head::zero_at_origin && B.head == Head::plain &&
            (V.head == Head::squared_norm || V_.outputs() == 1),
        "fused loss: found heads {}, {}, {}, expected zero_at_origin or plain, squared_norm or plain, plain",
        to_string(f.head), to_string(V.head), to_string(B.head));
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
  const auto tiles = [&](const PointsView<T>& points, Work work, double cost) {
    for (ptrdiff_t first = 0; first < points.count; first += FusedNetwork<T>::tile_rows) {
      work.points = points.data + first * dimension_;
      work.first = first;
      work.rows = std::min(FusedNetwork<T>::tile_rows, points.count - first);
      work.cost = cost * static_cast<double>(work.rows);
      all.push_back(work);
    }
  };
  const auto products = [](const FusedNetwork<T>& network) {
    return static_cast<double>(network.parameters());
  };
  const auto region = [&](const PointsView<T>& points, double weight, double sign, double margin,
                          LossTerm term) {
    Work work{.kind = Work::Kind::region, .points = nullptr, .first = 0, .rows = 0};
    work.weight = points.count > 0 ? weight / static_cast<double>(points.count) : 0.0;
    work.sign = sign;
    work.margin = margin;
    work.term = term;
    tiles(points, work, 3.0 * products(B_));
  };
  using Kind = typename Work::Kind;
  tiles(batch.workspace, {.kind = Kind::workspace, .points = nullptr, .first = 0, .rows = 0},
        3.0 * products(f_) + 6.0 * (products(V_) + products(B_)));
  if (options_.weight[LossTerm::imitation] > 0.0 && trains_ == Trains::all)
    tiles(batch.position, {.kind = Kind::demonstrations, .points = nullptr, .first = 0, .rows = 0},
          3.0 * products(f_));
  if (options_.weight[LossTerm::obstacle_normal] > 0.0 && options_.kind != "paper" && trains_ == Trains::all)
    tiles(batch.boundary, {.kind = Kind::boundary, .points = nullptr, .first = 0, .rows = 0},
          3.0 * products(f_));
  region(batch.initial, options_.weight[LossTerm::barrier_sets], 1.0, options_.margin_initial,
         LossTerm::barrier_sets);
  region(batch.unsafe, options_.weight[LossTerm::barrier_sets], -1.0, options_.margin_unsafe,
         LossTerm::barrier_sets);
  if (options_.kind != "paper") {
    region(batch.safe, options_.weight[LossTerm::rollout_safety], 1.0, options_.margin_rollout_safety,
           LossTerm::rollout_safety);
    region(batch.unsafe_rollouts, options_.weight[LossTerm::rollout_safety], -1.0,
           options_.margin_rollout_safety, LossTerm::rollout_safety);
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
    f_.forward(1, origin_.data(), nullptr, f_at_origin_.data(), nullptr, nullptr);
  if (shape_V_.head != Head::plain)
    V_.forward(1, origin_.data(), nullptr, V_at_origin_.data(), nullptr, nullptr);
}

template <typename T>
void FusedLoss<T>::run_demonstrations(Chunk& chunk, const Work& work, const BatchView<T>& batch) const {
  const ptrdiff_t n = dimension_;
  const T* target = batch.velocity.data + work.first * n;
  const double share = 1.0 / static_cast<double>(batch.position.count);
  chunk.f.forward(work.rows, work.points, nullptr, chunk.velocity.data(), nullptr);
  for (ptrdiff_t i = 0; i < work.rows * n; ++i) {
    const T error = chunk.velocity[i] - f_at_origin_[i % n] - target[i];
    chunk.sums[LossTerm::imitation] += options_.weight[LossTerm::imitation] * share *
                                       static_cast<double>(error) * static_cast<double>(error);
    const T adjoint = static_cast<T>(2.0 * options_.weight[LossTerm::imitation] * share) * error;
    chunk.velocity_adjoint[i] = adjoint;
    chunk.f_origin_adjoint[i % n] -= adjoint;
  }
  chunk.f.backward(chunk.velocity_adjoint.data(), nullptr, nullptr);
}

template <typename T>
void FusedLoss<T>::run_boundary(Chunk& chunk, const Work& work, const BatchView<T>& batch) const {
  const ptrdiff_t n = dimension_;
  const double weight =
      options_.weight[LossTerm::obstacle_normal] / static_cast<double>(batch.boundary.count);
  chunk.f.forward(work.rows, work.points, nullptr, chunk.velocity.data(), nullptr);
  for (ptrdiff_t s = 0; s < work.rows; ++s) {
    const T* normal = batch.normal.data + (work.first + s) * n;
    double leaving = 0.0;
    for (ptrdiff_t k = 0; k < n; ++k)
      leaving +=
          static_cast<double>(normal[k]) * static_cast<double>(chunk.velocity[s * n + k] - f_at_origin_[k]);
    const Penalty penalty = rectify(options_.margin_obstacle_normal - leaving, 0.0);
    chunk.sums[LossTerm::obstacle_normal] += weight * penalty.value;
    for (ptrdiff_t k = 0; k < n; ++k) {
      const T adjoint = static_cast<T>(-weight * penalty.slope) * normal[k];
      chunk.velocity_adjoint[s * n + k] = adjoint;
      chunk.f_origin_adjoint[k] -= adjoint;
    }
  }
  chunk.f.backward(chunk.velocity_adjoint.data(), nullptr, nullptr);
}

template <typename T>
void FusedLoss<T>::run_region(Chunk& chunk, const Work& work) const {
  chunk.B.forward(work.rows, work.points, nullptr, chunk.barrier.data(), nullptr);
  const double leak = options_.kind == "paper" ? options_.leak : 0.0;
  for (ptrdiff_t i = 0; i < work.rows; ++i) {
    const Penalty penalty = rectify(work.sign * static_cast<double>(chunk.barrier[i]) + work.margin, leak);
    chunk.sums[work.term] += work.weight * penalty.value;
    chunk.barrier_adjoint[i] = static_cast<T>(work.weight * work.sign * penalty.slope);
  }
  chunk.B.backward(chunk.barrier_adjoint.data(), nullptr, nullptr);
}

namespace {

// The lyapunov and barrier_decrease terms of one sample, and their derivatives in V, Vdot, B and Bdot.
struct SampleLoss {
  double lyapunov = 0.0, barrier_decrease = 0.0;
  double by_V = 0.0, by_V_dot = 0.0, by_B_dot = 0.0;
};

SampleLoss robust_loss(const LossOptions& o, double V, double V_dot, double B, double B_dot) {
  SampleLoss loss;
  const double scale = V + 1e-6, q = V_dot / scale + o.decay_rate;
  if (!(q <= 0.0)) {
    loss.lyapunov = o.weight[LossTerm::lyapunov] * std::log1p(q);
    loss.by_V_dot = o.weight[LossTerm::lyapunov] / (1.0 + q) / scale;
    loss.by_V = -loss.by_V_dot * V_dot / scale;
  }
  const double z = B_dot + o.margin_barrier_decrease;
  if (!(z <= 0.0)) {
    const double weight =
        o.weight[LossTerm::barrier_decrease] * std::exp(-(B / o.band_width) * (B / o.band_width));
    loss.barrier_decrease = weight * z;
    loss.by_B_dot = weight;
  }
  return loss;
}

SampleLoss paper_loss(const LossOptions& o, double V, double V_dot, double B_dot) {
  const Penalty positive = rectify(o.margin_positive - V, o.leak);
  const Penalty decrease = rectify(V_dot - o.margin_decrease, o.leak);
  const Penalty barrier_decrease = rectify(B_dot - o.margin_barrier_decrease, o.leak);
  return {.lyapunov = o.weight[LossTerm::lyapunov] * (positive.value + decrease.value),
          .barrier_decrease = o.weight[LossTerm::barrier_decrease] * barrier_decrease.value,
          .by_V = -o.weight[LossTerm::lyapunov] * positive.slope,
          .by_V_dot = o.weight[LossTerm::lyapunov] * decrease.slope,
          .by_B_dot = o.weight[LossTerm::barrier_decrease] * barrier_decrease.slope};
}

}  // namespace

template <typename T>
void FusedLoss<T>::run_workspace(Chunk& chunk, const Work& work, const BatchView<T>& batch) const {
  const ptrdiff_t n = dimension_, m = V_.outputs(), rows = work.rows;
  const bool squared = shape_V_.head == Head::squared_norm, paper = options_.kind == "paper";
  const double share = 1.0 / static_cast<double>(batch.workspace.count);
  const T* x = work.points;
  T* direction = chunk.velocity.data();
  chunk.f.forward(rows, x, nullptr, direction, nullptr);
  for (ptrdiff_t i = 0; i < rows * n; ++i) direction[i] -= f_at_origin_[i % n];
  const bool with_V = options_.weight[LossTerm::lyapunov] > 0.0;
  if (with_V) chunk.V.forward(rows, x, direction, chunk.features.data(), chunk.tangent.data());
  chunk.B.forward(rows, x, direction, chunk.barrier.data(), chunk.barrier_dot.data());

  T* direction_adjoint = chunk.velocity_adjoint.data();
  for (ptrdiff_t s = 0; s < rows; ++s) {
    T* feature = chunk.features.data() + s * m;
    const T* tangent = chunk.tangent.data() + s * m;
    double V = with_V ? feature[0] : 0.0, V_dot = with_V ? tangent[0] : 0.0;
    if (with_V && squared) {
      V = V_dot = 0.0;
      for (ptrdiff_t j = 0; j < m; ++j) {
        feature[j] -= V_at_origin_[j];
        V += static_cast<double>(feature[j]) * static_cast<double>(feature[j]);
        V_dot += 2.0 * static_cast<double>(feature[j]) * static_cast<double>(tangent[j]);
      }
      for (ptrdiff_t k = 0; k < n; ++k) {
        const double point = x[s * n + k];
        V += shape_V_.quadratic * point * point;
        V_dot += 2.0 * shape_V_.quadratic * point * static_cast<double>(direction[s * n + k]);
      }
    }
    const double B = chunk.barrier[s], B_dot = chunk.barrier_dot[s];
    const SampleLoss loss =
        paper ? paper_loss(options_, V, V_dot, B_dot) : robust_loss(options_, V, V_dot, B, B_dot);
    chunk.sums[LossTerm::lyapunov] += share * loss.lyapunov;
    chunk.sums[LossTerm::barrier_decrease] += share * loss.barrier_decrease;
    const double by_V = share * loss.by_V, by_V_dot = share * loss.by_V_dot;
    T* feature_adjoint = chunk.features_adjoint.data() + s * m;
    T* tangent_adjoint = chunk.tangent_adjoint.data() + s * m;
    if (with_V && squared) {
      for (ptrdiff_t j = 0; j < m; ++j) {
        feature_adjoint[j] =
            static_cast<T>(2.0 * by_V) * feature[j] + static_cast<T>(2.0 * by_V_dot) * tangent[j];
        tangent_adjoint[j] = static_cast<T>(2.0 * by_V_dot) * feature[j];
        chunk.V_origin_adjoint[j] -= feature_adjoint[j];
      }
    } else {
      feature_adjoint[0] = static_cast<T>(by_V);
      tangent_adjoint[0] = static_cast<T>(by_V_dot);
    }
    chunk.barrier_adjoint[s] = T(0);  // the band's weight is held constant
    chunk.barrier_dot_adjoint[s] = static_cast<T>(share * loss.by_B_dot);
    for (ptrdiff_t k = 0; k < n; ++k)
      direction_adjoint[s * n + k] = static_cast<T>(2.0 * shape_V_.quadratic * by_V_dot) * x[s * n + k];
  }

  if (trains_ == Trains::barrier) {
    chunk.B.backward(chunk.barrier_adjoint.data(), chunk.barrier_dot_adjoint.data(), nullptr);
    return;
  }
  const auto add_part = [&] {
    for (ptrdiff_t i = 0; i < rows * n; ++i) direction_adjoint[i] += chunk.part[i];
  };
  if (with_V) {
    chunk.V.backward(chunk.features_adjoint.data(), chunk.tangent_adjoint.data(), chunk.part.data());
    add_part();
  }
  chunk.B.backward(chunk.barrier_adjoint.data(), chunk.barrier_dot_adjoint.data(), chunk.part.data());
  add_part();
  for (ptrdiff_t i = 0; i < rows * n; ++i) chunk.f_origin_adjoint[i % n] -= direction_adjoint[i];
  chunk.f.backward(direction_adjoint, nullptr, nullptr);
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
  if (shape_f_.head == Head::zero_at_origin) go_back(chunk.f, &Chunk::f_origin_adjoint, f_at_origin_);
  if (shape_V_.head == Head::squared_norm) go_back(chunk.V, &Chunk::V_origin_adjoint, V_at_origin_);
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
    for (const Work& work : chunk.work) {
      if (work.kind == Work::Kind::demonstrations) run_demonstrations(chunk, work, batch);
      if (work.kind == Work::Kind::boundary) run_boundary(chunk, work, batch);
      if (work.kind == Work::Kind::workspace) run_workspace(chunk, work, batch);
      if (work.kind == Work::Kind::region) run_region(chunk, work);
    }
  };
  if (cost < kLeastParallelWork) {
    for (ptrdiff_t c = 0; c < kChunks; ++c) run_chunk(c, 0);
  } else {
    parallel_for(kChunks, run_chunk);
  }
  if (trains_ == Trains::all) run_origins();

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
