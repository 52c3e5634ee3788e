#include <ATen/ATen.h>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/region.h"

namespace s2nnds {

at::Tensor Region::level(const at::Tensor& x) const {
  if (!x.defined() || x.dim() != 2 || x.size(1) != dimension() || !x.is_floating_point()) {
    fail("{}: expected a floating-point tensor [N, {}]", describe(), dimension());
  }
  const at::Tensor doubles = x.detach().to(at::kCPU, at::kDouble).contiguous();
  const Vector levels = level(Eigen::Map<const Points>(doubles.data_ptr<double>(), x.size(0), x.size(1)));
  at::Tensor result = at::empty({x.size(0)}, doubles.options());
  Eigen::Map<Vector>(result.data_ptr<double>(), levels.size()) = levels;
  return result.to(x.device(), x.scalar_type());
}

}  // namespace s2nnds
