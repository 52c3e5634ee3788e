// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/core/options.h"
#include "s2nnds/data/demonstration.h"

namespace s2nnds {

// The frame of the data, which is the user's: where its goal lies, and how positions in it become what
// networks are trained and proofs are made in, normalised units with the goal at the origin.
//   position -> (position - goal) / position_scale
//   velocity -> velocity / velocity_scale
//   time     -> (time - first time) / time_scale()
// so that d(position)/d(time) = velocity holds in normalised units too.
struct Frame {
  std::string unit;                       // of length in the data: "mm", "m"; "" when unknown
  std::string name;                       // of the data's frame: "base_link"; "" when not told
  std::string normalization = "max_abs";  // what the scales are the largest of: max_abs, max_norm
  Vector goal;                            // [n] in `unit`: the point of the data's frame that is the origin
  // [K, n] in `unit`: what is subtracted from each demonstration. All rows are the goal, unless each
  // demonstration is moved to end there.
  Points goals;
  // [4] unit quaternion (orientation.h): the mean of the demonstrations' last orientations; empty without orientations.
  Vector goal_orientation = {};
  std::string quaternion_order = {};  // of the user's quaternions: xyzw or wxyz; "" without orientations
  // In `unit`: where the last coordinate, a phase (phase.h), starts; 0: all coordinates are those of a place.
  double phase_start = 0.0;
  double position_scale = 1.0;  // `unit` per normalised length
  double velocity_scale = 1.0;  // `unit` per second and normalised velocity

  // Seconds per unit of normalised time.
  double time_scale() const { return position_scale / velocity_scale; }

  // Demonstrations as read, K of them, in normalised units. Throws Error when there are not K.
  std::vector<Demonstration> normalize(const std::vector<Demonstration>& as_read) const;
  // Normalised positions [N, n] in the data's unit and frame.
  Points to_data(const Points& normalised) const;
  Vector to_data(const Vector& normalised) const;  // one position [n]

  // "(500, 200) mm": a position [n] in the data's frame, to some five digits of the motion's size wherever the goal
  // lies; of a state with a phase "(500, 200) mm, s = 340 mm".
  enum class Rounding { nearest, up, down };
  std::string position_text(const Vector& position, Rounding rounding = Rounding::nearest) const;

  bool has_orientation() const { return goal_orientation.size() > 0; }  // whether what moves are poses
  bool has_phase() const { return phase_start > 0.0; }  // whether the last coordinate is a phase
  Eigen::Index places() const { return goal.size() - (has_phase() ? 1 : 0); }  // coordinates of a place
  Frame of_places() const;                                                     // the same without the phase

  // How far the end of each demonstration as read lies from the goal, in `unit`: [K].
  Vector end_distances(const std::vector<Demonstration>& as_read) const;
  // Whether demonstrations that end elsewhere are moved to end at the goal.
  bool moves_demonstrations() const;

  // Throws Error starting with `where` unless the scales are finite and > 0 and the goals are finite and
  // [count, dimension].
  void check(std::size_t count, Eigen::Index dimension, const std::string& where) const;
};

// The frame of demonstrations as read. `goal` says where the goal lies:
//   "mean":  the mean of the demonstrations' last positions. No demonstration is moved.
//   numbers: this point [n], in the data's unit. No demonstration is moved.
//   "each":  as "mean", and every demonstration is moved so that it ends there.
// The scales are taken over all demonstrations: max_abs takes the largest absolute coordinate (seen from the
// goal), max_norm the largest Euclidean norm. Throws Error when there is no motion (a scale of zero), and
// when an end lies farther from a goal that moves no demonstration than `largest_end_share` of the motion's
// extent, the longest side of the box around all positions; when a demonstration's last orientation is turned from
// their mean by more than largest_end_turn, or another one by almost 180 degrees.
Frame find_frame(const DemonstrationSet& as_read, const std::string& normalization,
                 const WordOrNumbers& goal = {"mean"});

inline constexpr double largest_end_share = 0.1;  // see find_frame
inline constexpr double largest_end_turn = 0.35;  // rad, 20 degrees

}  // namespace s2nnds
