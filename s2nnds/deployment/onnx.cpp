// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/onnx.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <onnx/onnx_pb.h>

#include <cstdint>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// Builds a graph node by node; every value has a name of its own.
class GraphBuilder {
 public:
  explicit GraphBuilder(onnx::GraphProto& graph) : graph_(graph) {}

  std::string constant(const std::vector<float>& values, const std::vector<std::int64_t>& shape) {
    onnx::TensorProto& tensor = *graph_.add_initializer();
    tensor.set_data_type(onnx::TensorProto::FLOAT);
    for (const std::int64_t size : shape) tensor.add_dims(size);
    for (const float value : values) tensor.add_float_data(value);
    tensor.set_name(next_name());
    return tensor.name();
  }
  std::string constant(double value) { return constant({static_cast<float>(value)}, {}); }
  std::string constant_double(const std::vector<double>& values) {
    onnx::TensorProto& tensor = *graph_.add_initializer();
    tensor.set_data_type(onnx::TensorProto::DOUBLE);
    tensor.add_dims(std::ssize(values));
    for (const double value : values) tensor.add_double_data(value);
    tensor.set_name(next_name());
    return tensor.name();
  }

  std::string axis_one() {
    onnx::TensorProto& tensor = *graph_.add_initializer();
    tensor.set_data_type(onnx::TensorProto::INT64);
    tensor.add_dims(1);
    tensor.add_int64_data(1);
    tensor.set_name(next_name());
    return tensor.name();
  }

  std::string node(const std::string& type, const std::vector<std::string>& inputs,
                   const std::vector<std::pair<std::string, std::int64_t>>& attributes = {},
                   const std::string& output = "") {
    onnx::NodeProto& node = *graph_.add_node();
    node.set_op_type(type);
    for (const std::string& input : inputs) node.add_input(input);
    for (const auto& [name, value] : attributes) {
      onnx::AttributeProto& attribute = *node.add_attribute();
      attribute.set_name(name);
      attribute.set_type(onnx::AttributeProto::INT);
      attribute.set_i(value);
    }
    const std::string result = output.empty() ? next_name() : output;
    node.add_output(result);
    node.set_name(type + "_" + result);
    return result;
  }

  // [N, n] -> [N]. Its axes are a list, which no other attribute here is.
  std::string least_of_row(const std::string& rows) {
    const std::string result = node("ReduceMin", {rows}, {{"keepdims", 0}});
    onnx::AttributeProto& axes = *graph_.mutable_node(graph_.node_size() - 1)->add_attribute();
    axes.set_name("axes");
    axes.set_type(onnx::AttributeProto::INTS);
    axes.add_ints(1);
    return result;
  }

 private:
  std::string next_name() { return fmt::format("value_{}", count_++); }

  onnx::GraphProto& graph_;
  int count_ = 0;
};

std::vector<float> floats(const double* data, Eigen::Index count) { return {data, data + count}; }

std::string activate(GraphBuilder& graph, Activation activation, const std::string& z) {
  switch (activation) {
    case Activation::identity:
      return z;
    case Activation::tanh:
      return graph.node("Tanh", {z});
    case Activation::elu:
      return graph.node("Elu", {z});
    case Activation::softplus:
      return graph.node("Softplus", {z});
    case Activation::silu:
      return graph.node("Mul", {z, graph.node("Sigmoid", {z})});
    case Activation::sine:
      return graph.node("Sin", {z});
  }
  fail("activation: found the unknown value {}", static_cast<int>(activation));
}

// y(z) for normalised z [N, n]: [N, m], or [N] for squared_norm.
std::string add_network(GraphBuilder& graph, const NetworkWeights& stack, const std::string& z) {
  check_fits_float(stack);
  std::string a = z;
  for (const Layer& layer : stack.layers) {
    std::vector<std::string> inputs = {a, graph.constant(floats(layer.weight.data(), layer.weight.size()),
                                                         {layer.weight.rows(), layer.weight.cols()})};
    if (layer.bias.size() > 0)
      inputs.push_back(graph.constant(floats(layer.bias.data(), layer.bias.size()), {layer.bias.size()}));
    a = activate(graph, layer.activation, graph.node("Gemm", inputs, {{"transB", 1}}));
  }
  if (stack.head != Head::plain) {
    const Points origin = layers_at_origin(stack);
    a = graph.node("Sub", {a, graph.constant(floats(origin.data(), origin.size()), {origin.size()})});
  }
  const auto sum_of_squares = [&](const std::string& v) {
    return graph.node("ReduceSum", {graph.node("Mul", {v, v}), graph.axis_one()}, {{"keepdims", 0}});
  };
  if (stack.head == Head::squared_norm) {
    return graph.node(
        "Add", {sum_of_squares(a), graph.node("Mul", {graph.constant(stack.quadratic), sum_of_squares(z)})});
  }
  return a;
}

void describe(onnx::ValueInfoProto& value, const std::string& name, std::int64_t columns,
              onnx::TensorProto::DataType element = onnx::TensorProto::DOUBLE) {
  value.set_name(name);
  onnx::TypeProto::Tensor& type = *value.mutable_type()->mutable_tensor_type();
  type.set_elem_type(element);
  type.mutable_shape()->add_dim()->set_dim_param("N");
  if (columns > 0) type.mutable_shape()->add_dim()->set_dim_value(columns);
}

std::string metadata(const std::string& value) { return value; }
std::string metadata(std::int64_t value) { return fmt::format("{}", value); }
std::string metadata(double value) { return fmt::format("{}", value); }
std::string metadata(const std::vector<double>& values) { return fmt::format("{}", fmt::join(values, ", ")); }

}  // namespace

std::string onnx_model(const Policy& policy) {
  const PolicyInfo& info = policy.info;
  onnx::ModelProto model;
  model.set_ir_version(7);
  model.set_producer_name("s2nnds");
  model.add_opset_import()->set_version(13);
  onnx::GraphProto& graph = *model.mutable_graph();
  graph.set_name("policy");
  describe(*graph.add_input(), "position", info.dimension);
  describe(*graph.add_output(), "velocity", info.dimension);
  describe(*graph.add_output(), "lyapunov", 0);
  describe(*graph.add_output(), "barrier", 0);
  describe(*graph.add_output(), "safe", 0, onnx::TensorProto::BOOL);
  GraphBuilder builder(graph);
  // Positions come and results go in double, the networks compute in float: a position far from the origin keeps
  // its digits until the goal is subtracted.
  const auto cast = [&](const std::string& value, onnx::TensorProto::DataType type,
                        const std::string& output = "") {
    return builder.node("Cast", {value}, {{"to", type}}, output);
  };
  const std::string from_goal = builder.node("Sub", {"position", builder.constant_double(info.goal)});
  const std::string scaled = builder.node("Div", {from_goal, builder.constant_double({info.position_scale})});
  const std::string z = cast(scaled, onnx::TensorProto::FLOAT);
  const std::string f = cast(add_network(builder, policy.networks.f, z), onnx::TensorProto::DOUBLE);
  builder.node("Mul", {f, builder.constant_double({info.velocity_scale})}, {}, "velocity");
  for (const auto& [stack, name] :
       {std::pair(&policy.networks.V, "lyapunov"), std::pair(&policy.networks.B, "barrier")}) {
    std::string y = add_network(builder, *stack, z);
    if (stack->head != Head::squared_norm) y = builder.node("Squeeze", {y, builder.axis_one()});
    cast(y, onnx::TensorProto::DOUBLE, name);
  }
  // In the workspace (all coordinates are: the least of 0 and 1 is 1), and B <= 0 by more than float may have lost.
  const auto middle = info.workspace.begin() + info.dimension;
  const std::string inside = builder.node(
      "And",
      {builder.node("GreaterOrEqual",
                    {"position", builder.constant_double({info.workspace.begin(), middle})}),
       builder.node("LessOrEqual", {"position", builder.constant_double({middle, info.workspace.end()})})});
  const std::string least = builder.least_of_row(cast(inside, onnx::TensorProto::DOUBLE));
  builder.node(
      "And",
      {cast(least, onnx::TensorProto::BOOL),
       builder.node("LessOrEqual", {"barrier", builder.constant_double({-info.barrier_float32_error})})},
      {}, "safe");
  info.visit([&](const char* name, const auto& value, const char*) {
    onnx::StringStringEntryProto& property = *model.add_metadata_props();
    property.set_key(name);
    property.set_value(metadata(value));
  });
  std::string bytes;
  check(model.SerializeToString(&bytes), "policy: ONNX refused the model");
  return bytes;
}

}  // namespace s2nnds
