// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/moved_motion.h"

#include "s2nnds/core/check.h"

namespace s2nnds {

MovedMotion::MovedMotion(const Networks& networks, const Displacement& displacement)
    : f_(networks), V_(networks.V), B_(networks.B), displacement_(displacement) {
  check(displacement.places() <= networks.f.input_dimension(),
        "moved motion: found a displacement of {} coordinates, expected at most {}", displacement.places(),
        networks.f.input_dimension());
}

Points MovedMotion::velocity(const Points& x, const Vector& p) const {
  const Points y = displacement_.preimage(x, p);
  return displacement_.pushed(y, f_.value(y), p);
}

Points MovedMotion::velocity(const Points& x, const Vector& p, const Vector& rate) const {
  const Points y = displacement_.preimage(x, p);
  Points v = displacement_.pushed(y, f_.value(y), p);
  check(rate.size() == p.size(), "moved motion: found a rate of {} coordinates, expected {}", rate.size(),
        p.size());
  v.leftCols(p.size()) += displacement_.bump(y) * rate.transpose();
  return v;
}

Points MovedMotion::lyapunov(const Points& x, const Vector& p) const {
  return V_.value(displacement_.preimage(x, p));
}
Points MovedMotion::barrier(const Points& x, const Vector& p) const {
  return B_.value(displacement_.preimage(x, p));
}

}  // namespace s2nnds
