// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "s2nnds/verification/perturbation.h"
#include "s2nnds/verification/tile_examiner.h"

namespace s2nnds {

// grad B . (f + delta) < 0 wherever B = 0. In three looks: B, the rate along f at places where B = 0, and, where that
// falls, what the perturbation adds at most.
class LevelSetExaminer : public TileExaminer {
 public:
  // `scale` >= 0: so many times the perturbation is to be withstood. `resolution` as TileExaminer's. Boxes at most as wide
  // as `hopeless_width` on which the rate hardly varies, and fails by more than that, are given up: their parts will fail
  // too, unless {B = 0} misses them. Giving up too early costs a certificate, never its truth.
  LevelSetExaminer(const ProofFunctions& functions, double resolution,
                   std::unique_ptr<Perturbation> perturbation, double scale, double hopeless_width);

 protected:
  // What is known of a box on which it holds and that {B = 0} may meet.
  struct Bounds {
    double rate;  // above Bdot wherever B = 0
    double work;  // above the perturbation's work, unscaled
  };
  virtual void on_proved(const Lane&, const Bounds&) {}

 private:
  void look(int count) override;
  std::optional<BoxStatus> judge(int count, const Lane& lane) override;

  TileRow& rate() { return noted_[0]; }
  TileRow& steady_rate() { return noted_[1]; }  // at the centre, where it hardly varies; else -infinity

  std::unique_ptr<Perturbation> perturbation_;
  double scale_, hopeless_width_;
  Eigen::Array<bool, tile_boxes, 1> meets_, hopeless_;
};

}  // namespace s2nnds
