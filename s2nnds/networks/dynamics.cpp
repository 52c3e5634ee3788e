// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/dynamics.h"

namespace s2nnds {

template <typename T>
BasicDynamicsEvaluator<T>::BasicDynamicsEvaluator(const Dynamics& dynamics)
    : f_(dynamics.f), decay_(dynamics.decay) {
  if (dynamics.is_projected()) V_.emplace(dynamics.V);
}

template <typename T>
BasicDynamicsEvaluator<T>::BasicDynamicsEvaluator(const Networks& networks)
    : f_(networks.f), decay_(networks.decay) {
  if (networks.is_projected()) V_.emplace(networks.V);
}

template <typename T>
Points BasicDynamicsEvaluator<T>::value(const Points& x) const {
  Points velocity = f_.value(x);
  if (!V_) return velocity;
  Vector value;
  Points gradient;
  V_->value_and_gradient(x, value, gradient);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    project_velocity(x.cols(), gradient.row(i).data(), value[i], decay_, velocity.row(i).data());
  return velocity;
}

template class BasicDynamicsEvaluator<float>;
template class BasicDynamicsEvaluator<double>;

Dynamics Networks::dynamics() const { return is_projected() ? Dynamics(f, decay, V) : Dynamics(f); }

Points Networks::velocity(const Points& x) const { return BasicDynamicsEvaluator<double>(*this).value(x); }

}  // namespace s2nnds
