// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace s2nnds {

// The terms of the training loss. Options (weights), losses (values), history and checkpoint carry one value
// a term, in a PerTerm.
enum class LossTerm : std::size_t {
  imitation,         // f on the demonstrations, the paper's (6)
  lyapunov,          // V positive and falling along motions, (7)
  barrier_sets,      // B <= 0 on X0, B > 0 on Xu and on the workspace's margin
  barrier_decrease,  // Bdot < 0 around {B = 0}
  rollout_safety,    // B <= 0 where rollouts are safe, B > 0 where they are not
  obstacle_normal,   // f points outwards on the obstacle's boundary
};

// In the order of the enumerators: keys of the configuration, columns of the history.
inline constexpr std::array<std::string_view, 6> loss_term_names = {
    "imitation", "lyapunov", "barrier_sets", "barrier_decrease", "rollout_safety", "obstacle_normal"};

// Every term, in the order of the enumerators.
inline constexpr auto all_loss_terms = [] {
  std::array<LossTerm, loss_term_names.size()> all{};
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<LossTerm>(k);
  return all;
}();

// The term's name: its enumerator.
constexpr std::string_view to_string(LossTerm term) {
  return loss_term_names[static_cast<std::size_t>(term)];
}

// One T for each term of the loss, found by the term.
template <typename T>
struct PerTerm : std::array<T, all_loss_terms.size()> {
  using Base = std::array<T, all_loss_terms.size()>;  // in the order of the enumerators
  // The value of one term.
  constexpr T& operator[](LossTerm term) { return Base::operator[](static_cast<std::size_t>(term)); }
  // The value of one term.
  constexpr const T& operator[](LossTerm term) const {
    return Base::operator[](static_cast<std::size_t>(term));
  }
};

}  // namespace s2nnds
