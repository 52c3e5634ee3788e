// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/onnx.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <onnx/onnx_pb.h>

#include <cstdint>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/data/orientation.h"

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
  std::string constant_double(const Points& values) {
    onnx::TensorProto& tensor = *graph_.add_initializer();
    tensor.set_data_type(onnx::TensorProto::DOUBLE);
    tensor.add_dims(values.rows());
    tensor.add_dims(values.cols());
    for (Eigen::Index i = 0; i < values.size(); ++i) tensor.add_double_data(values.data()[i]);
    tensor.set_name(next_name());
    return tensor.name();
  }
  // These columns of [N, m], in this order.
  std::string columns(const std::string& rows, const std::vector<std::int64_t>& which) {
    onnx::TensorProto& tensor = *graph_.add_initializer();
    tensor.set_data_type(onnx::TensorProto::INT64);
    tensor.add_dims(std::ssize(which));
    for (const std::int64_t index : which) tensor.add_int64_data(index);
    tensor.set_name(next_name());
    return node("Gather", {rows, tensor.name()}, {{"axis", 1}});
  }
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

// y(z) for normalised z [N, n]: [N, m], or [N] for sums of squares.
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
  if (stack.head == Head::diffeomorphism) return sum_of_squares(graph.node("Add", {a, z}));
  if (stack.head == Head::squared_norm) {
    return graph.node(
        "Add", {sum_of_squares(a), graph.node("Mul", {graph.constant(stack.quadratic), sum_of_squares(z)})});
  }
  return a;
}

// The velocity [N, n] that is nearest to f [N, n] and along which V falls fast enough (project_velocity), at the
// normalised positions z [N, n]; all double.
std::string add_projection(GraphBuilder& graph, const Networks& networks, const std::string& z,
                           const std::string& f) {
  const auto node = [&](const char* type, const std::string& a, const std::string& b) {
    return graph.node(type, {a, b});
  };
  const auto number = [&](double value) { return graph.constant_double(std::vector<double>{value}); };
  const auto sum = [&](const std::string& rows) {
    return graph.node("ReduceSum", {rows, graph.axis_one()}, {{"keepdims", 1}});
  };
  std::string a = z;
  std::vector<std::string> slopes;  // of each layer, "" of an identity
  for (const Layer& layer : networks.V.layers) {
    a = node("MatMul", a, graph.constant_double(Points(layer.weight.transpose())));
    if (layer.bias.size() > 0)
      a = node("Add", a, graph.constant_double(std::vector<double>(layer.bias.begin(), layer.bias.end())));
    slopes.emplace_back();
    if (layer.activation == Activation::identity) continue;
    check(layer.activation == Activation::tanh,
          "onnx: found a projected f whose V has the activation {}, expected tanh",
          to_string(layer.activation));
    a = graph.node("Tanh", {a});
    slopes.back() = node("Sub", number(1.0), node("Mul", a, a));
  }
  const std::string phi = node("Add", z, node("Sub", a, graph.constant_double(layers_at_origin(networks.V))));
  std::string pulled = phi;
  for (std::size_t k = slopes.size(); k-- > 0;) {
    if (!slopes[k].empty()) pulled = node("Mul", pulled, slopes[k]);
    pulled = node("MatMul", pulled, graph.constant_double(networks.V.layers[k].weight));
  }
  const std::string gradient = node("Mul", number(2.0), node("Add", phi, pulled));
  const std::string needed = node("Mul", number(networks.decay), sum(node("Mul", phi, phi)));
  const std::string excess = graph.node("Relu", {node("Add", sum(node("Mul", gradient, f)), needed)});
  const std::string square =
      node("Max", sum(node("Mul", gradient, gradient)), number(std::numeric_limits<double>::min()));
  return node("Sub", f, node("Mul", node("Div", excess, square), gradient));
}

void describe(onnx::ValueInfoProto& value, const std::string& name, std::int64_t columns,
              onnx::TensorProto::DataType element = onnx::TensorProto::DOUBLE) {
  value.set_name(name);
  onnx::TypeProto::Tensor& type = *value.mutable_type()->mutable_tensor_type();
  type.set_elem_type(element);
  type.mutable_shape()->add_dim()->set_dim_param("N");
  if (columns > 0) type.mutable_shape()->add_dim()->set_dim_value(columns);
}

// The angular velocity of a policy of poses, as the C++ header computes it (cpp_header.cpp): [N, 3] from the normalised
// positions `z` and their velocities `dz` (per second), both double.
class AngularVelocity {
 public:
  AngularVelocity(GraphBuilder& graph, const Policy& policy) : graph_(graph), policy_(policy) {}

  void add(const std::string& z, const std::string& dz, const std::string& output) {
    const std::string r = rotation_vector();
    const auto [target, change] = psi_along(z, dz);
    const std::string rate = sub(change, mul(number(policy_.info.orientation_rate), sub(r, target)));
    const std::string square = graph_.node("ReduceSum", {mul(r, r), graph_.axis_one()}, {{"keepdims", 1}});
    const std::string angle = graph_.node("Sqrt", {square});
    const std::string small = graph_.node("Less", {angle, number(1e-4)});
    const std::string sine = graph_.node("Sin", {mul(number(0.5), angle)});
    // 1 - cos a = 2 sin^2 (a / 2)
    const std::string first = graph_.node("Where", {small, sub(number(0.5), div(square, number(24))),
                                                    div(mul(number(2), mul(sine, sine)), square)});
    const std::string second =
        graph_.node("Where", {small, sub(number(1.0 / 6), div(square, number(120))),
                              div(sub(angle, graph_.node("Sin", {angle})), mul(square, angle))});
    const std::string once = cross(r, rate), twice = cross(r, once);
    const std::string turned = add(rate, add(mul(first, once), mul(second, twice)));
    const Points to_data = rotation_matrix(goal_orientation_of(policy_.info)).transpose();
    graph_.node("MatMul", {turned, graph_.constant_double(to_data)}, {}, output);
  }

 private:
  std::string number(double value) { return graph_.constant_double(std::vector<double>{value}); }
  std::string add(const std::string& a, const std::string& b) { return graph_.node("Add", {a, b}); }
  std::string sub(const std::string& a, const std::string& b) { return graph_.node("Sub", {a, b}); }
  std::string mul(const std::string& a, const std::string& b) { return graph_.node("Mul", {a, b}); }
  std::string div(const std::string& a, const std::string& b) { return graph_.node("Div", {a, b}); }
  std::string cross(const std::string& a, const std::string& b) {
    return sub(mul(graph_.columns(a, {1, 2, 0}), graph_.columns(b, {2, 0, 1})),
               mul(graph_.columns(a, {2, 0, 1}), graph_.columns(b, {1, 2, 0})));
  }

  // log(q_goal^-1 q): the product is linear in q.
  std::string rotation_vector() {
    const Eigen::Vector4d inverse_goal = inverse(goal_orientation_of(policy_.info));
    Points map(4, 4);  // row: a number of the user's q; column: w, x, y, z of the product
    for (Eigen::Index i = 0; i < 4; ++i) {
      const Eigen::Vector4d unit = from_order(Eigen::Vector4d::Unit(i), policy_.info.quaternion_order);
      map.row(i) = product(inverse_goal, unit).transpose();
    }
    const std::string square =
        graph_.node("ReduceSum", {mul("orientation", "orientation"), graph_.axis_one()}, {{"keepdims", 1}});
    const std::string unit = div("orientation", graph_.node("Sqrt", {square}));
    const std::string q = graph_.node("MatMul", {unit, graph_.constant_double(map)});
    const std::string real = graph_.columns(q, {0}), imaginary = graph_.columns(q, {1, 2, 3});
    const std::string sine = graph_.node(
        "Sqrt",
        {graph_.node("ReduceSum", {mul(imaginary, imaginary), graph_.axis_one()}, {{"keepdims", 1}})});
    const std::string cosine = graph_.node("Abs", {real});
    // Runtimes know it in float alone. Its error is corrected by one step of Newton's method in double: with the angle's
    // sine and cosine, a + (s cos a - c sin a).
    const std::string ratio = cast(div(sine, cosine), onnx::TensorProto::FLOAT);
    const std::string rough = cast(graph_.node("Atan", {ratio}), onnx::TensorProto::DOUBLE);
    const std::string sine_rough = graph_.node("Sin", {rough});
    const std::string cosine_rough = graph_.node("Sin", {sub(number(M_PI / 2), rough)});
    const std::string half = add(rough, sub(mul(sine, cosine_rough), mul(cosine, sine_rough)));
    const std::string share = graph_.node("Where", {graph_.node("Less", {sine, number(1e-8)}),
                                                    div(number(2), cosine), div(mul(number(2), half), sine)});
    const std::string sign =
        graph_.node("Where", {graph_.node("Less", {real, number(0)}), number(-1), number(1)});
    return mul(mul(sign, share), imaginary);
  }

  // psi and its derivative along dz, whose hidden layers are tanh.
  std::pair<std::string, std::string> psi_along(const std::string& z, const std::string& dz) {
    const NetworkWeights& psi = policy_.orientation->psi;
    std::string a = z, d = dz;
    for (const Layer& layer : psi.layers) {
      const std::string weight = graph_.constant_double(Points(layer.weight.transpose()));
      a = graph_.node("MatMul", {a, weight});
      d = graph_.node("MatMul", {d, weight});
      if (layer.bias.size() > 0)
        a = add(a, graph_.constant_double(std::vector<double>(layer.bias.begin(), layer.bias.end())));
      if (layer.activation == Activation::identity) continue;
      check(layer.activation == Activation::tanh, "policy: found psi with the activation {}, expected tanh",
            to_string(layer.activation));
      a = graph_.node("Tanh", {a});
      d = mul(d, sub(number(1), mul(a, a)));
    }
    const Points origin = layers_at_origin(psi);
    return {sub(a, graph_.constant_double(origin)), d};
  }
  std::string cast(const std::string& value, onnx::TensorProto::DataType type) {
    return graph_.node("Cast", {value}, {{"to", type}});
  }

  GraphBuilder& graph_;
  const Policy& policy_;
};

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
  if (policy.orientation) describe(*graph.add_input(), "orientation", 4);
  describe(*graph.add_output(), "velocity", info.dimension);
  describe(*graph.add_output(), "lyapunov", 0);
  describe(*graph.add_output(), "barrier", 0);
  describe(*graph.add_output(), "safe", 0, onnx::TensorProto::BOOL);
  if (policy.orientation) describe(*graph.add_output(), "angular_velocity", 3);
  GraphBuilder builder(graph);
  // Positions come and results go in double, the networks compute in float: a position far from the origin keeps
  // its digits until the goal is subtracted.
  const auto cast = [&](const std::string& value, onnx::TensorProto::DataType type,
                        const std::string& output = "") {
    return builder.node("Cast", {value}, {{"to", type}}, output);
  };
  const std::string from_goal = builder.node("Sub", {"position", builder.constant_double(info.goal)});
  const std::string scaled =
      builder.node("Div", {from_goal, builder.constant_double(std::vector<double>{info.position_scale})});
  const std::string z = cast(scaled, onnx::TensorProto::FLOAT);
  std::string f = cast(add_network(builder, policy.networks.f, z), onnx::TensorProto::DOUBLE);
  if (policy.networks.is_projected()) f = add_projection(builder, policy.networks, scaled, f);
  builder.node("Mul", {f, builder.constant_double(std::vector<double>{info.velocity_scale})}, {}, "velocity");
  if (policy.orientation) {
    const std::string dz =
        builder.node("Div", {"velocity", builder.constant_double(std::vector<double>{info.position_scale})});
    AngularVelocity(builder, policy).add(scaled, dz, "angular_velocity");
  }
  for (const auto& [stack, name] :
       {std::pair(&policy.networks.V, "lyapunov"), std::pair(&policy.networks.B, "barrier")}) {
    std::string y = add_network(builder, *stack, z);
    if (!is_sum_of_squares(stack->head)) y = builder.node("Squeeze", {y, builder.axis_one()});
    cast(y, onnx::TensorProto::DOUBLE, name);
  }
  // In the workspace (all coordinates are: the least of 0 and 1 is 1), and B <= 0 by more than float may have lost.
  const auto middle = info.workspace.begin() + info.dimension;
  const std::string inside = builder.node(
      "And", {builder.node("GreaterOrEqual", {"position", builder.constant_double(std::vector<double>{
                                                              info.workspace.begin(), middle})}),
              builder.node("LessOrEqual", {"position", builder.constant_double(std::vector<double>{
                                                           middle, info.workspace.end()})})});
  const std::string least = builder.least_of_row(cast(inside, onnx::TensorProto::DOUBLE));
  builder.node(
      "And",
      {cast(least, onnx::TensorProto::BOOL),
       builder.node("LessOrEqual",
                    {"barrier", builder.constant_double(std::vector<double>{-info.barrier_float32_error})})},
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
