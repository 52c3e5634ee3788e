#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace s2nnds {

// The terms of the training loss. Options (weights), losses (values), history and checkpoint carry one value a
// term, in a PerTerm.
enum class LossTerm : std::size_t {
  imitation,         // f on the demonstrations, the paper's (6)
  lyapunov,          // V positive and falling along motions, (7)
  barrier_sets,      // B <= 0 on X0, B > 0 on Xu and on the workspace's margin
  barrier_decrease,  // Bdot < 0 around {B = 0}
  rollout_safety,    // B <= 0 where rollouts are safe, B > 0 where they are not
  obstacle_normal,   // f points outwards on the obstacle's boundary
};

inline constexpr std::array<LossTerm, 6> all_loss_terms = {
    LossTerm::imitation,        LossTerm::lyapunov,       LossTerm::barrier_sets,
    LossTerm::barrier_decrease, LossTerm::rollout_safety, LossTerm::obstacle_normal};

constexpr std::string_view to_string(LossTerm term) {
  constexpr std::array<std::string_view, all_loss_terms.size()> names = {
      "imitation", "lyapunov", "barrier_sets", "barrier_decrease", "rollout_safety", "obstacle_normal"};
  return names[static_cast<std::size_t>(term)];
}

// One T for every term of the loss.
template <typename T>
struct PerTerm : std::array<T, all_loss_terms.size()> {
  using Base = std::array<T, all_loss_terms.size()>;
  constexpr T& operator[](LossTerm term) { return Base::operator[](static_cast<std::size_t>(term)); }
  constexpr const T& operator[](LossTerm term) const { return Base::operator[](static_cast<std::size_t>(term)); }
};

}  // namespace s2nnds
