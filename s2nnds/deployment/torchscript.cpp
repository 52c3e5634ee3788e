// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/torchscript.h"

#include <torch/script.h>

#include <cstdint>
#include <sstream>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

torch::Tensor to_float32(const double* data, std::vector<std::int64_t> shape) {
  return torch::from_blob(const_cast<double*>(data), shape, torch::kFloat64).to(torch::kFloat32);
}

std::string call(Activation activation, const std::string& z) {
  switch (activation) {
    case Activation::identity:
      return z;
    case Activation::tanh:
      return "torch.tanh(" + z + ")";
    case Activation::elu:
      return "torch.elu(" + z + ")";
    case Activation::softplus:
      return "torch.softplus(" + z + ", 1, 40)";
    case Activation::silu:
      return "torch.silu(" + z + ")";
    case Activation::sine:
      return "torch.sin(" + z + ")";
  }
  fail("activation: found the unknown value {}", static_cast<int>(activation));
}

// Registers the weights of one network under `prefix` and returns the source of its method prefix(z),
// z [N, n] normalised -> [N, m].
std::string define_network(torch::jit::Module& module, const NetworkWeights& stack,
                           const std::string& prefix) {
  check_fits_float(stack);
  std::string source = "def " + prefix + "(self, z: Tensor) -> Tensor:\n  a = z\n";
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    const Layer& layer = stack.layers[k];
    const std::string weight = fmt::format("{}_weight_{}", prefix, k),
                      bias = fmt::format("{}_bias_{}", prefix, k);
    module.register_parameter(
        weight, to_float32(layer.weight.data(), {layer.weight.rows(), layer.weight.cols()}), false);
    std::string z = fmt::format("torch.linear(a, self.{})", weight);
    if (layer.bias.size() > 0) {
      module.register_parameter(bias, to_float32(layer.bias.data(), {layer.bias.size()}), false);
      z = fmt::format("torch.linear(a, self.{}, self.{})", weight, bias);
    }
    source += "  a = " + call(layer.activation, z) + "\n";
  }
  if (stack.head != Head::plain) {
    const Points at_origin = layers_at_origin(stack);
    module.register_buffer(prefix + "_origin", to_float32(at_origin.data(), {at_origin.cols()}));
    source += fmt::format("  a = a - self.{}_origin\n", prefix);
  }
  if (stack.head == Head::squared_norm) {
    source +=
        fmt::format("  return ((a * a).sum(1) + {:.17g} * (z * z).sum(1)).unsqueeze(1)\n", stack.quadratic);
  } else {
    source += "  return a\n";
  }
  return source;
}

void set_attributes(torch::jit::Module& module, const PolicyInfo& info) {
  info.visit([&](const char* name, const auto& value, const char*) {
    const torch::IValue constant(value);
    module.register_attribute(name, constant.type(), constant);
  });
}

// Goal and workspace are lists, not buffers, which would follow a module that is cast to another precision; what is
// compared with them and subtracted from is float64 whatever the positions are. (torch.tensor of numbers would round
// them to float32 first.) The weights are rounded to float32, so that its bound counts in float64 as well.
void define_interface(torch::jit::Module& module) {
  module.define(fmt::format(R"(
def constants(self, values: List[float], x: Tensor) -> Tensor:
  tensor = torch.zeros([len(values)], dtype={0}, device=x.device)
  for i, value in enumerate(values):
    tensor[i].fill_(value)
  return tensor

def normalised(self, x: Tensor) -> Tensor:
  z = (x.to({0}) - self.constants(self.goal, x)) / self.position_scale
  return z.to(self.B_weight_0.dtype)

def forward(self, x: Tensor) -> Tensor:
  return (self.f(self.normalised(x)) * self.velocity_scale).to(x.dtype)

def lyapunov(self, x: Tensor) -> Tensor:
  return self.V(self.normalised(x)).squeeze(1).to(x.dtype)

def barrier(self, x: Tensor) -> Tensor:
  return self.B(self.normalised(x)).squeeze(1).to(x.dtype)

def safe(self, x: Tensor) -> Tensor:
  corners = self.constants(self.workspace, x)
  y = x.to({0})
  inside = (y >= corners[:self.dimension]) & (y <= corners[self.dimension:])
  barrier = self.B(self.normalised(x)).squeeze(1)
  assert barrier.dtype == {1} or barrier.dtype == {0}, "safe: found another precision than float32 and float64"
  return (barrier <= -self.barrier_float32_error) & inside.all(1)
)",
                            static_cast<int>(torch::kFloat64), static_cast<int>(torch::kFloat32)));
}

// In memory: when a write fails, torch's own file writer throws out of its destructor and ends the program.
std::string serialised(const torch::jit::Module& module) {
  std::ostringstream bytes;
  module.save(bytes);
  return bytes.str();
}

}  // namespace

std::string torchscript_module(const Policy& policy) {
  check_plain_motion(policy, "torchscript");
  torch::jit::Module module("S2nndsPolicy");
  set_attributes(module, policy.info);
  try {
    module.define(define_network(module, policy.networks.f, "f"));
    module.define(define_network(module, policy.networks.V, "V"));
    module.define(define_network(module, policy.networks.B, "B"));
    define_interface(module);
    module.eval();
  } catch (const c10::Error& e) {
    fail("policy: TorchScript refused the module: {}", e.what_without_backtrace());
  }
  return serialised(module);
}

}  // namespace s2nnds
