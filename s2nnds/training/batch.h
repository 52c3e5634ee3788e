// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <utility>

namespace s2nnds {

// The sets of points of a training step.
enum class Samples : std::size_t {
  workspace,
  demonstrations,  // and corrections; each with a velocity
  boundary,        // of the obstacle; each with the unit normal outwards
  initial,
  unsafe,  // of Xu, the workspace margin and the counterexamples of both
  safe,    // where rollouts are safe
  unsafe_rollouts,
};

inline constexpr std::array<Samples, 7> all_samples = {
    Samples::workspace, Samples::demonstrations, Samples::boundary,       Samples::initial,
    Samples::unsafe,    Samples::safe,           Samples::unsafe_rollouts};

// The points of one training step, normalised coordinates, one T [N, n] a set: Points as drawn, tensors,
// PointsView. Empty where there is nothing to draw.
template <typename T>
struct BatchOf {
  T position, velocity, workspace, initial, unsafe, safe, unsafe_rollouts, boundary, normal;

  // The points of each of Samples, in its order, and what comes with every point, if anything does.
  using Member = T BatchOf::*;
  static constexpr std::array<std::pair<Member, Member>, all_samples.size()> sets = {{
      {&BatchOf::workspace, nullptr},
      {&BatchOf::position, &BatchOf::velocity},
      {&BatchOf::boundary, &BatchOf::normal},
      {&BatchOf::initial, nullptr},
      {&BatchOf::unsafe, nullptr},
      {&BatchOf::safe, nullptr},
      {&BatchOf::unsafe_rollouts, nullptr},
  }};
  const T& points(Samples set) const { return this->*sets[static_cast<std::size_t>(set)].first; }
  T beside(Samples set) const {
    const Member member = sets[static_cast<std::size_t>(set)].second;
    return member ? this->*member : T{};
  }
};

// The batch with `function` of each of its fields.
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
