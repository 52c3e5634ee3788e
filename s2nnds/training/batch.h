// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <utility>

namespace s2nnds {

// The sets of points of a training step.
enum class Samples : std::size_t {
  workspace,        // of X
  demonstrations,   // and corrections; each with a velocity
  boundary,         // of the obstacle; each with the unit normal outwards
  initial,          // of X0, and along the demonstrations
  unsafe,           // of Xu, the workspace margin and the counterexamples of both
  safe,             // where rollouts are safe
  unsafe_rollouts,  // where rollouts are not safe, and along motions followed back into {B > 0}
};

// Every set, in the order in which losses are added up.
inline constexpr std::array<Samples, 7> all_samples = {
    Samples::workspace, Samples::demonstrations, Samples::boundary,       Samples::initial,
    Samples::unsafe,    Samples::safe,           Samples::unsafe_rollouts};

// The points of one training step in normalised coordinates. T holds N points [N, n]: Points, torch::Tensor
// or PointsView. A set is empty where there is nothing to draw.
template <typename T>
struct BatchOf {
  T position,           // samples of the demonstrations, and corrections
      velocity,         // what f should be there
      workspace,        // points of X
      initial,          // points of X0, and some along the demonstrations
      unsafe,           // points of Xu, of the workspace margin and counterexamples of both
      safe,             // points whose rollouts are safe
      unsafe_rollouts,  // points whose rollouts are not safe, and of motions followed back into {B > 0}
      boundary,         // points of the obstacle's boundary
      normal;           // the unit normals there, outwards

  using Member = T BatchOf::*;  // names one of the fields above
  // For each of Samples, in the order of its enumerators: its points, and what lies beside them (or null).
  static constexpr std::array<std::pair<Member, Member>, all_samples.size()> sets = {{
      {&BatchOf::workspace, nullptr},
      {&BatchOf::position, &BatchOf::velocity},
      {&BatchOf::boundary, &BatchOf::normal},
      {&BatchOf::initial, nullptr},
      {&BatchOf::unsafe, nullptr},
      {&BatchOf::safe, nullptr},
      {&BatchOf::unsafe_rollouts, nullptr},
  }};
  // The points of a set.
  const T& points(Samples set) const { return this->*sets[static_cast<std::size_t>(set)].first; }
  // What lies beside them: velocities or normals [N, n]; T{} for a set that has neither.
  T beside(Samples set) const {
    const Member member = sets[static_cast<std::size_t>(set)].second;
    return member ? this->*member : T{};
  }
};

// Applies `function` to each field of the batch.
template <typename Result, typename T, typename Function>
BatchOf<Result> transform(const BatchOf<T>& batch, Function function) {
  BatchOf<Result> result;
  for (std::size_t k = 0; k < batch.sets.size(); ++k) {
    const auto [from, from_beside] = BatchOf<T>::sets[k];
    const auto [to, to_beside] = BatchOf<Result>::sets[k];
    result.*to = function(batch.*from);
    if (to_beside) result.*to_beside = function(batch.*from_beside);
  }
  return result;
}

}  // namespace s2nnds
