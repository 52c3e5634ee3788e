#include "s2nnds/deployment/torchscript.h"

#include <torch/script.h>
#include <torch/torch.h>

#include <sstream>

#include "s2nnds/core/atomic_file.h"
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

// Registers the weights of one network under `prefix` and returns the source of its method prefix(z), z [N,
// n] normalised -> [N, m].
std::string define_network(torch::jit::Module& module, const NetworkWeights& stack,
                           const std::string& prefix) {
  stack.check();
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
    NetworkWeights plain = stack;
    plain.head = Head::plain;
    const Points at_origin = plain.value(Points::Zero(1, stack.input_dimension()));
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

void define_interface(torch::jit::Module& module) {
  module.define(R"(
def normalised(self, x: Tensor) -> Tensor:
  return x.to(self.B_weight_0.dtype) / self.position_scale

def forward(self, x: Tensor) -> Tensor:
  return (self.f(self.normalised(x)) * self.velocity_scale).to(x.dtype)

def lyapunov(self, x: Tensor) -> Tensor:
  return self.V(self.normalised(x)).squeeze(1).to(x.dtype)

def barrier(self, x: Tensor) -> Tensor:
  return self.B(self.normalised(x)).squeeze(1).to(x.dtype)

def safe(self, x: Tensor) -> Tensor:
  inside = (x >= self.workspace_lower.to(x.dtype)) & (x <= self.workspace_upper.to(x.dtype))
  return (self.barrier(x) <= 0) & inside.all(1)
)");
}

// In memory first: when a write fails, torch's own file writer throws out of its destructor and ends the
// program.
std::string serialised(const torch::jit::Module& module) {
  std::ostringstream bytes;
  module.save(bytes);
  return bytes.str();
}

}  // namespace

void export_torchscript(const Networks& networks, const PolicyInfo& info, const std::string& path) {
  torch::jit::Module module("S2nndsPolicy");
  const std::int64_t n = networks.f.input_dimension();
  check(info.workspace_lower.size() == n && info.workspace_upper.size() == n,
        "policy: found a workspace of dimension {}, expected {}", info.workspace_lower.size(), n);
  const Vector lower = info.position_scale * info.workspace_lower,
               upper = info.position_scale * info.workspace_upper;
  std::vector<double> corners(lower.begin(), lower.end());
  corners.insert(corners.end(), upper.begin(), upper.end());
  const auto attribute = [&](const std::string& name, const c10::TypePtr& type, const torch::IValue& value) {
    module.register_attribute(name, type, value);
  };
  attribute("position_scale", c10::FloatType::get(), info.position_scale);
  attribute("velocity_scale", c10::FloatType::get(), info.velocity_scale);
  attribute("dimension", c10::IntType::get(), n);
  attribute("name", c10::StringType::get(), info.name);
  attribute("unit", c10::StringType::get(), info.unit);
  attribute("guarantee", c10::StringType::get(), info.guarantee);
  attribute("statement", c10::StringType::get(), info.statement);
  attribute("weight_hash", c10::StringType::get(), weight_hash(networks));
  attribute("workspace", c10::ListType::ofFloats(), corners);
  module.register_buffer("workspace_lower", torch::from_blob(corners.data(), {n}, torch::kFloat64).clone());
  module.register_buffer("workspace_upper",
                         torch::from_blob(corners.data() + n, {n}, torch::kFloat64).clone());
  try {
    module.define(define_network(module, networks.f, "f"));
    module.define(define_network(module, networks.V, "V"));
    module.define(define_network(module, networks.B, "B"));
    define_interface(module);
    module.eval();
  } catch (const c10::Error& e) {
    fail("policy: TorchScript refused the module: {}", e.what_without_backtrace());
  }
  write_atomic_file(path, serialised(module), "the policy");
}

}  // namespace s2nnds
