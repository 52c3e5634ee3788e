#include "s2nnds/networks/fused_function.h"

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::tensor_list;

// What backward needs besides tensors; kept alive by the context through a capsule.
template <typename T>
struct Recorded : torch::CustomClassHolder {
  std::shared_ptr<FusedNetwork<T>> network;
  typename FusedNetwork<T>::Tape tape;
};

template <typename T>
class FusedFunction : public torch::autograd::Function<FusedFunction<T>> {
 public:
  static tensor_list forward(AutogradContext* context, const torch::Tensor& x, const torch::Tensor& direction,
                             const torch::Tensor& theta, std::shared_ptr<FusedNetwork<T>> network,
                             bool record) {
    const std::int64_t samples = x.size(0);
    const bool tangent = direction.numel() > 0;
    network->load(theta.data_ptr<T>());
    torch::Tensor value = torch::empty({samples, network->outputs()}, x.options());
    torch::Tensor derivative = tangent ? torch::empty_like(value) : torch::empty({0}, x.options());
    auto recorded = c10::make_intrusive<Recorded<T>>();
    network->forward(samples, x.data_ptr<T>(), tangent ? direction.data_ptr<T>() : nullptr,
                     value.data_ptr<T>(), tangent ? derivative.data_ptr<T>() : nullptr,
                     record ? &recorded->tape : nullptr);
    if (record) {
      recorded->network = std::move(network);
      context->save_for_backward({x, direction});
      context->saved_data["recorded"] = c10::IValue::make_capsule(std::move(recorded));
    }
    return {value, derivative};
  }

  static tensor_list backward(AutogradContext* context, tensor_list adjoints) {
    const auto saved = context->get_saved_variables();
    const torch::Tensor& x = saved[0];
    const torch::Tensor& direction = saved[1];
    const auto capsule = context->saved_data["recorded"].toCapsule();
    const auto& recorded = static_cast<const Recorded<T>&>(*capsule);
    const FusedNetwork<T>& network = *recorded.network;
    const bool tangent = recorded.tape.tangent;
    const auto dense = [&](const torch::Tensor& adjoint) {
      if (adjoint.defined()) return adjoint.contiguous();
      return torch::zeros({recorded.tape.samples, static_cast<std::int64_t>(network.outputs())}, x.options());
    };
    const torch::Tensor value_adjoint = dense(adjoints[0]);
    const torch::Tensor tangent_adjoint = tangent ? dense(adjoints[1]) : torch::Tensor();
    torch::Tensor theta_gradient =
        torch::empty({static_cast<std::int64_t>(network.parameters())}, x.options());
    torch::Tensor direction_gradient = tangent ? torch::empty_like(direction) : torch::Tensor();
    network.backward(x.data_ptr<T>(), tangent ? direction.data_ptr<T>() : nullptr, recorded.tape,
                     value_adjoint.data_ptr<T>(), tangent ? tangent_adjoint.data_ptr<T>() : nullptr,
                     theta_gradient.data_ptr<T>(), tangent ? direction_gradient.data_ptr<T>() : nullptr);
    return {torch::Tensor(), direction_gradient, theta_gradient, torch::Tensor(), torch::Tensor()};
  }
};

}  // namespace

template <typename T>
std::pair<torch::Tensor, torch::Tensor> fused_apply(const std::shared_ptr<FusedNetwork<T>>& network,
                                                    const torch::Tensor& x, const torch::Tensor& direction,
                                                    const torch::Tensor& theta) {
  const auto fits = [&](const torch::Tensor& t) { return t.dim() == 2 && t.size(1) == network->inputs(); };
  check(fits(x) && (!direction.defined() || (fits(direction) && direction.size(0) == x.size(0))),
        "network: expected points (and directions) [N, {}]", network->inputs());
  check(!x.requires_grad(), "network: the fused engine has no gradient in x; use the autograd engine");
  const torch::Tensor along =
      direction.defined() ? direction.contiguous() : torch::empty({0, x.size(1)}, x.options());
  const bool record = torch::GradMode::is_enabled() && (theta.requires_grad() || along.requires_grad());
  const tensor_list out = FusedFunction<T>::apply(x.contiguous(), along, theta, network, record);
  return {out[0], direction.defined() ? out[1] : torch::Tensor()};
}

template std::pair<torch::Tensor, torch::Tensor> fused_apply<float>(
    const std::shared_ptr<FusedNetwork<float>>&, const torch::Tensor&, const torch::Tensor&,
    const torch::Tensor&);
template std::pair<torch::Tensor, torch::Tensor> fused_apply<double>(
    const std::shared_ptr<FusedNetwork<double>>&, const torch::Tensor&, const torch::Tensor&,
    const torch::Tensor&);

}  // namespace s2nnds
