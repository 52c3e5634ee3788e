// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/evaluation/state_function.h"

#include <memory>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

template <typename T>
std::function<Points(const Points&)> in_precision(const NetworkWeights& network) {
  return [packed = std::make_shared<const BasicEvaluator<T>>(network)](const Points& x) {
    return packed->value(x);
  };
}

}  // namespace

StateFunction::StateFunction(const Dynamics& dynamics)
    : value_([packed = std::make_shared<const BasicDynamicsEvaluator<double>>(dynamics)](const Points& x) {
        return packed->value(x);
      }),
      quick_value_([packed = std::make_shared<const BasicDynamicsEvaluator<float>>(dynamics)](
                       const Points& x) { return packed->value(x); }) {}

StateFunction::StateFunction(const NetworkWeights& network)
    : value_(in_precision<double>(network)), quick_value_(in_precision<float>(network)) {}

void check_outputs(const StateFunction& function, const Vector& point, Eigen::Index outputs,
                   const char* where) {
  const Points y = function.value(point.transpose());
  check(y.rows() == 1 && y.cols() == outputs,
        "{}: found values [{}, {}] of one point [1, {}], expected [1, {}]", where, y.rows(), y.cols(),
        point.size(), outputs);
}

}  // namespace s2nnds
