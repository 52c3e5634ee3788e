// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/cpp_header.h"

#include <fmt/ranges.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "s2nnds/core/check.h"
#include "s2nnds/data/orientation.h"
#include "s2nnds/deployment/displaced_source.h"
#include "s2nnds/deployment/policy_kernels.h"
#include "s2nnds/networks/dense_kernels.h"

namespace s2nnds {
namespace {

constexpr Eigen::Index kNarrow = 8;  // fewer outputs are computed one by one, along the inputs
constexpr std::size_t kNumbersALine = 10;

// A literal that the compiler reads back as exactly this value, rounded to float if `single`.
std::string literal(double value, bool single) {
  return single ? fmt::format("{:#}F", static_cast<float>(value)) : fmt::format("{:#}", value);
}

std::string string_literal(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\' || c == '?') {  // "??" begins trigraphs
      result += fmt::format("\\{}", c);
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      result += fmt::format("\\{:03o}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string_view functor(Activation activation) {
  switch (activation) {
    case Activation::identity:
      return "Identity";
    case Activation::tanh:
      return "Tanh";
    case Activation::elu:
      return "Elu";
    case Activation::softplus:
      return "Softplus";
    case Activation::silu:
      return "Silu";
    case Activation::sine:
      return "Sine";
  }
  fail("activation: found the unknown value {}", static_cast<int>(activation));
}

using Text = fmt::memory_buffer;
template <typename... Args>
void put(Text& text, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
}

// One network as source: its weights, layers(x, y) = N(x), and the function of its head.
class NetworkSource {
 public:
  NetworkSource(Text& text, std::string name, const NetworkWeights& stack, bool single)
      : text_(text),
        name_(std::move(name)),
        stack_(stack),
        single_(single),
        real_(single ? "float" : "double") {
    if (single) check_fits_float(stack);
  }

  void write_all() {
    for (std::size_t k = 0; k < stack_.layers.size(); ++k) write_weights(k);
    write_layers();
    if (stack_.head != Head::plain) write_origin();
    write_head();
  }

  // NAME_gradient(x, gradient) of a scalar network whose head has the layers' slope; of a diffeomorphism
  // NAME_gradient(x, gradient, value).
  void write_gradient() {
    const auto last = stack_.layers.size() - 1;
    const bool diffeomorphism = stack_.head == Head::diffeomorphism;
    put(text_, "inline void {}_gradient(const double* x, double* gradient{}) noexcept {{\n", name_,
        diffeomorphism ? ", double& value" : "");
    for (std::size_t k = 0; k <= last; ++k) {
      const Eigen::Index out = padded(stack_.layers[k].weight.rows());
      put(text_, "  alignas(64) double z{0}[{1}], a{0}[{1}], slope{0}[{1}], adjoint{0}[{1}] = {{}};\n", k,
          out);
      write_layer(k, k == 0 ? "x" : fmt::format("a{}", k - 1), fmt::format("z{}", k), false);
      put(text_, "  activate_with_slopes<{0}, {1}>(z{2}, a{2}, slope{2});\n",
          functor(stack_.layers[k].activation), out, k);
    }
    if (diffeomorphism) {
      put(text_,
          "  static const {0}_at_origin origin;\n"
          "  double phi[{1}];\n"
          "  value = 0;\n"
          "  for (int i = 0; i < {1}; ++i) {{\n"
          "    phi[i] = a{2}[i] - origin.y[i] + x[i];\n"
          "    value += phi[i] * phi[i];\n"
          "    adjoint{2}[i] = 2 * phi[i];\n"
          "  }}\n",
          name_, stack_.input_dimension(), last);
    } else {
      put(text_, "  adjoint{}[0] = 1.0;\n", last);
    }
    for (std::size_t k = last + 1; k-- > 0;) {
      const Points& weight = stack_.layers[k].weight;
      put(text_, "  for (int i = 0; i < {}; ++i) adjoint{}[i] *= slope{}[i];\n", weight.rows(), k, k);
      const std::string to = k == 0 ? "gradient" : fmt::format("adjoint{}", k - 1);
      const Eigen::Index in = weight.cols(), out = weight.rows();
      put(text_, "  {}<{}, {}>({}_weight_{}, adjoint{}, {});\n",
          is_narrow(k) ? "pull_back_narrow" : "pull_back", is_narrow(k) ? padded(in) : in,
          is_narrow(k) ? out : padded(out), name_, k, k, to);
    }
    if (diffeomorphism)
      put(text_, "  for (int i = 0; i < {}; ++i) gradient[i] += 2 * phi[i];\n", stack_.input_dimension());
    put(text_, "}}\n\n");
  }

  // NAME_along(x, dx, y, dy): the layers' output less N(0), and its derivative along dx.
  void write_derivative() {
    const std::size_t last = stack_.layers.size() - 1;
    put(text_,
        "// y [{0}] of the normalised position x [{1}], and dy its derivative along dx\n"
        "inline void {2}_along(const double* x, const double* dx, double* y, double* dy) noexcept {{\n",
        stack_.output_dimension(), stack_.input_dimension(), name_);
    std::string from = "x", change = "dx";
    for (std::size_t k = 0; k <= last; ++k) {
      const Eigen::Index in = stack_.layers[k].weight.cols(), out = padded(stack_.layers[k].weight.rows());
      put(text_, "  alignas(64) double z{0}[{1}], a{0}[{1}], slope{0}[{1}], d{0}[{1}];\n", k, out);
      write_layer(k, from, fmt::format("z{}", k), false);
      put(text_, "  activate_with_slopes<{0}, {1}>(z{2}, a{2}, slope{2});\n",
          functor(stack_.layers[k].activation), out, k);
      put(text_, "  alignas(64) static constexpr double {}_none_{}[{}] = {{}};\n", name_, k, out);
      if (is_narrow(k)) {
        put(text_,
            "  dense_narrow<double, {0}>({1}_weight_{2}, {1}_none_{2}, {3}, d{2}, "
            "std::make_integer_sequence<int, {4}>());\n",
            padded(in), name_, k, change, stack_.layers[k].weight.rows());
      } else {
        put(text_, "  dense<double, {0}, {1}>({2}_weight_{3}, {2}_none_{3}, {4}, d{3});\n", in, out, name_, k,
            change);
      }
      put(text_, "  for (int i = 0; i < {0}; ++i) d{1}[i] *= slope{1}[i];\n", out, k);
      from = fmt::format("a{}", k);
      change = fmt::format("d{}", k);
    }
    put(text_,
        "  static const {0}_at_origin origin;\n"
        "  for (int i = 0; i < {1}; ++i) {{\n"
        "    y[i] = a{2}[i] - origin.y[i];\n"
        "    dy[i] = d{2}[i];\n"
        "  }}\n"
        "}}\n\n",
        name_, stack_.output_dimension(), last);
  }

 private:
  // The last layer's output padded, which is what layers() fills.
  Eigen::Index outputs() const { return padded(stack_.layers.back().weight.rows()); }
  bool is_narrow(std::size_t k) const {
    const Points& weight = stack_.layers[k].weight;
    return k > 0 && weight.rows() < kNarrow && weight.cols() >= kLanePadding;
  }

  void write_array(const std::string& name, const Points& values) {
    put(text_, "alignas(64) inline constexpr {} {}[{}] = {{", real_, name, values.size());
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const bool first = static_cast<std::size_t>(i) % kNumbersALine == 0;
      put(text_, "{}{}", i == 0 ? "\n    " : first ? ",\n    " : ", ", literal(values.data()[i], single_));
    }
    put(text_, "}};\n");
  }

  void write_weights(std::size_t k) {
    const Layer& layer = stack_.layers[k];
    const Points& weight = layer.weight;
    Points stored;
    if (is_narrow(k)) {
      stored.setZero(weight.rows(), padded(weight.cols()));
      stored.leftCols(weight.cols()) = weight;
    } else {
      stored.setZero(weight.cols(), padded(weight.rows()));
      stored.leftCols(weight.rows()) = weight.transpose();
    }
    Points bias = Points::Zero(1, padded(weight.rows()));
    if (layer.bias.size() > 0) bias.leftCols(weight.rows()) = layer.bias.transpose();
    write_array(fmt::format("{}_weight_{}", name_, k), stored);
    write_array(fmt::format("{}_bias_{}", name_, k), bias);
  }

  void write_layers() {
    Eigen::Index widest = 0;
    for (const Layer& layer : stack_.layers) widest = std::max(widest, padded(layer.weight.rows()));
    put(text_, "inline void {}_layers(const {}* x, {}* y) noexcept {{\n", name_, real_, real_);
    if (stack_.layers.size() > 1) put(text_, "  alignas(64) {} a[{}];\n", real_, widest);
    if (stack_.layers.size() > 2) put(text_, "  alignas(64) {} b[{}];\n", real_, widest);
    std::string from = "x";
    for (std::size_t k = 0; k < stack_.layers.size(); ++k) {
      const std::string to = k + 1 == stack_.layers.size() ? "y" : k % 2 == 0 ? "a" : "b";
      write_layer(k, from, to);
      from = to;
    }
    put(text_, "}}\n");
  }

  void write_layer(std::size_t k, const std::string& from, const std::string& to, bool activated = true) {
    const Layer& layer = stack_.layers[k];
    const Eigen::Index in = layer.weight.cols(), out = layer.weight.rows();
    const std::string arrays = fmt::format("{0}_weight_{1}, {0}_bias_{1}, {2}, {3}", name_, k, from, to);
    if (is_narrow(k)) {
      put(text_, "  dense_narrow<{}, {}>({}, std::make_integer_sequence<int, {}>());\n", real_, padded(in),
          arrays, out);
    } else {
      put(text_, "  dense<{}, {}, {}>({});\n", real_, in, padded(out), arrays);
    }
    if (!activated || layer.activation == Activation::identity) return;
    put(text_, "  activate<{}, {}>({});\n", functor(layer.activation), padded(out), to);
  }

  // N(0), by the same instructions as N(x), so that the two cancel exactly at the goal.
  void write_origin() {
    put(text_,
        "struct {0}_at_origin {{\n"
        "  alignas(64) {1} y[{2}];\n"
        "  {0}_at_origin() noexcept {{\n"
        "    volatile {1} zero = 0;  // or the compiler would evaluate this by itself, rounding in its own "
        "way\n"
        "    {1} x[{3}];\n"
        "    for ({1}& value : x) value = zero;\n"
        "    {0}_layers(x, y);\n"
        "  }}\n"
        "}};\n",
        name_, real_, outputs(), stack_.input_dimension());
  }

  void write_head() {
    const Eigen::Index m = stack_.layers.back().weight.rows();
    put(text_,
        "// y [{0}] of the normalised position x [{1}]\n"
        "inline void {2}(const {3}* x, {3}* y) noexcept {{\n"
        "  alignas(64) {3} raw[{4}];\n"
        "  {2}_layers(x, raw);\n",
        stack_.output_dimension(), stack_.input_dimension(), name_, real_, outputs());
    if (stack_.head != Head::plain) {
      put(text_,
          "  static const {0}_at_origin origin;\n"
          "  for (int i = 0; i < {1}; ++i) raw[i] -= origin.y[i];\n",
          name_, m);
    }
    if (stack_.head == Head::diffeomorphism) {
      put(text_,
          "  y[0] = 0;\n"
          "  for (int i = 0; i < {0}; ++i) y[0] += (raw[i] + x[i]) * (raw[i] + x[i]);\n",
          m);
    } else if (stack_.head == Head::squared_norm) {
      put(text_,
          "  {0} features = 0, distance = 0;\n"
          "  for (int i = 0; i < {1}; ++i) features += raw[i] * raw[i];\n"
          "  for (int i = 0; i < {2}; ++i) distance += x[i] * x[i];\n"
          "  y[0] = features + {3} * distance;\n",
          real_, m, stack_.input_dimension(), literal(stack_.quadratic, single_));
    } else {
      put(text_, "  for (int i = 0; i < {}; ++i) y[i] = raw[i];\n", m);
    }
    put(text_, "}}\n\n");
  }

  Text& text_;
  std::string name_;
  const NetworkWeights& stack_;
  bool single_;
  const char* real_;
};

void write_head(Text& text, const std::string& space) {
  put(text, R"(// A robot motion, learned and checked by s2nnds: x' = velocity(x). Generated; do not edit.
// Compile with optimisation and for the processor at hand (-O3 -march=native); no other flag is needed.
#pragma once

#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0)
#error "compile without -ffast-math: it changes what was certified, and hides NaN"
#endif
static_assert(FLT_EVAL_METHOD == 0 || FLT_EVAL_METHOD == 16, "expected arithmetic in the type's own precision");

namespace {} {{

)",
      space);
}

// The declaration of a constant and its value.
std::string constant(const std::string& name, const std::string& value) {
  return fmt::format("char {}[] = {}", name, string_literal(value));
}
std::string constant(const std::string& name, std::int64_t value) {
  return fmt::format("int {} = {}", name, value);
}
std::string constant(const std::string& name, double value) {
  if (!std::isfinite(value)) return fmt::format("double {} = HUGE_VAL", name);
  return fmt::format("double {} = {}", name, literal(value, false));
}
std::string constant(const std::string& name, const std::vector<double>& values) {
  std::vector<std::string> literals;
  for (const double value : values) literals.push_back(literal(value, false));
  return fmt::format("double {}[{}] = {{{}}}", name, values.size(), fmt::join(literals, ", "));
}

void write_constants(Text& text, const PolicyInfo& info, bool single) {
  const auto write = [&](const char* name, const auto& value, const char* meaning) {
    put(text, "inline constexpr {};  // {}\n", constant(name, value), meaning);
  };
  info.visit(write);
  write("precision", std::string(single ? "float" : "double"), "of f; V and B are computed in double");
}

constexpr const char* kVectors = R"(
namespace detail {

#if !defined(__GNUC__) || defined(POLICY_WITHOUT_VECTORS)
#define SIMD_REGISTER_BYTES 0
#elif defined(__AVX512F__)
#define SIMD_REGISTER_BYTES 64
#elif defined(__AVX__)
#define SIMD_REGISTER_BYTES 32
#else
#define SIMD_REGISTER_BYTES 16
#endif
)";

constexpr const char* kInterface = R"(#undef SIMD_REGISTER_BYTES

template <typename Real>
struct Normalised {{  // the networks' argument of the position x
  Real z[dimension];
  explicit Normalised(const double* x) noexcept {{
    for (int i = 0; i < dimension; ++i) z[i] = static_cast<Real>((x[i] - goal[i]) / position_scale);
  }}
}};
}}  // namespace detail

// v [dimension] = the velocity, in `unit` per second, at the position x [dimension], in `unit` and in the frame of
// the demonstrations, where the goal is at `goal`.
inline void velocity(const double* x, double* v) noexcept {{
  {0} y[dimension];
  detail::f(detail::Normalised<{0}>(x).z, y);
{1}}}

// The Lyapunov function at the position x [dimension]: it falls along motions, to 0 at the goal.
inline double lyapunov(const double* x) noexcept {{
  double y = 0.0;
  detail::V(detail::Normalised<double>(x).z, &y);
  return y;
}}

// The barrier function at the position x [dimension]: motions that start where it is <= 0 stay there.
inline double barrier(const double* x) noexcept {{
  double y = 0.0;
  detail::B(detail::Normalised<double>(x).z, &y);
  return y;
}}

// Whether x [dimension] lies in the workspace. False for NaN.
inline bool in_workspace(const double* x) noexcept {{
  for (int i = 0; i < dimension; ++i) {{
    if (!(x[i] >= workspace[i] && x[i] <= workspace[dimension + i])) return false;
  }}
  return true;
}}

// Whether x [dimension] lies in the safe set: the barrier is <= 0, by more than rounding may have lost, and x is inside
// the workspace. False for NaN.
inline bool safe(const double* x) noexcept {{ return in_workspace(x) && barrier(x) <= -barrier_float64_error; }}

)";

// The end of velocity(): of f itself, and of a projected f, {} its decay in normalised units.
constexpr const char* kVelocity =
    "  for (int i = 0; i < dimension; ++i) v[i] = static_cast<double>(y[i]) * velocity_scale;\n";
constexpr const char* kProjectedVelocity =
    R"(  // Projected on the velocities along which the Lyapunov function falls at least as fast as exp(-decay t).
  double gradient[dimension], value = 0, rate = 0, square = 0;
  detail::V_gradient(detail::Normalised<double>(x).z, gradient, value);
  for (int i = 0; i < dimension; ++i) {{
    rate += gradient[i] * static_cast<double>(y[i]);
    square += gradient[i] * gradient[i];
  }}
  const double excess = rate + {} * value;
  const double share = excess <= 0 ? 0 : excess / std::fmax(square, DBL_MIN);
  for (int i = 0; i < dimension; ++i) v[i] = (static_cast<double>(y[i]) - share * gradient[i]) * velocity_scale;
)";

constexpr const char* kShield =
    R"(// v [dimension] = v_wanted [dimension], changed so that a robot that moves as `execution` says, and starts in the safe
// set, never leaves it. v_wanted is first shortened to most_command. Near the edge of the safe set, or outside, it then
// becomes the nearest of the velocities that lead away from the edge at least as certainly as the motion's own,
// execution_speed * velocity(x), does; and where that is faster than most_command, one on the way from it to the
// motion's own. Returns |v - v_wanted|: 0 deep inside the safe set for velocities within most_command, and wherever the
// motion's own is wanted at a reading of a place in the safe set. Where v_wanted is not finite, or its square is not, v
// is the motion's own, and where x is not, v is 0; both return HUGE_VAL.
inline double shield(const double* x, const double* v_wanted, double* v) noexcept {
  constexpr int n = dimension;
  const detail::Normalised<double> at(x);
  double own[n], gradient[n], off[n];
  velocity(x, own);
  double wanted_square = 0, own_square = 0;
  for (int i = 0; i < n; ++i) {
    own[i] *= execution_speed;
    own_square += own[i] * own[i];
    wanted_square += v_wanted[i] * v_wanted[i];
  }
  if (!std::isfinite(own_square)) {
    for (int i = 0; i < n; ++i) v[i] = 0;
    return HUGE_VAL;
  }
  if (!std::isfinite(wanted_square)) {
    for (int i = 0; i < n; ++i) v[i] = own[i];
    return HUGE_VAL;
  }
  const double wanted = std::sqrt(wanted_square);
  const double share = wanted > most_command ? most_command / wanted * (1 - 1e-15) : 1;
  bool changed = share < 1;
  for (int i = 0; i < n; ++i) v[i] = share * v_wanted[i];
  if (!(in_workspace(x) && barrier(x) < -(shield_band + barrier_float64_error))) {
    detail::B_gradient(at.z, gradient);
    double size = 0, distance = 0, along = 0;
    for (int i = 0; i < n; ++i) {
      off[i] = v[i] - own[i];
      // The motion's own velocity, computed elsewhere: compilers that fuse operations may round it otherwise there.
      if (std::fabs(off[i]) <= 1e-15 * std::fabs(own[i])) off[i] = 0;
      size += gradient[i] * gradient[i];
      distance += off[i] * off[i];
      along -= gradient[i] * off[i];
    }
    size = std::sqrt(size);
    // The cone around the axis -gradient: along >= cosine * size * distance, with room for rounding.
    const double cosine = (shield_cone * (1 + 1e-6)) / size + 1e-9;
    if (!(along >= cosine * size * std::sqrt(distance))) {
      changed = true;
      along /= size;
      const double across = std::sqrt(std::fmax(0.0, distance - along * along));
      const double sine = std::sqrt(std::fmax(0.0, 1 - cosine * cosine));
      const double length = cosine * along + sine * across;
      const bool any = cosine < 1 && length > 0 && across > 0;
      double square = 0, mixed = 0;
      for (int i = 0; i < n; ++i) {
        const double axis = -gradient[i] / size;
        off[i] = any ? length * (cosine * axis + sine * ((off[i] - along * axis) / across)) : 0;
        square += off[i] * off[i];
        mixed += off[i] * own[i];
      }
      const double room = std::fmax(0.0, most_command * most_command - own_square);
      double kept = 1;
      if (square + 2 * mixed > room) {
        kept = std::fmin(1.0, std::fmax(0.0, (std::sqrt(mixed * mixed + square * room) - mixed) / square)) * (1 - 1e-12);
      }
      for (int i = 0; i < n; ++i) v[i] = own[i] + kept * off[i];
    }
  }
  if (!changed) return 0;
  double change = 0;
  for (int i = 0; i < n; ++i) change += (v[i] - v_wanted[i]) * (v[i] - v_wanted[i]);
  return std::sqrt(change);
}

)";

// {0}: places of w, x, y, z in the user's order; {1}: the inverse of the goal's orientation (w, x, y, z); {2}: its rotation
// matrix, row by row.
constexpr const char* kOrientation =
    R"(// As above, and omega [3], in rad/s, the angular velocity in the frame of the demonstrations (q' = 1/2 (0, omega) q) of the
// orientation q [4], in the order `quaternion_order`; q is made a unit quaternion, and q and -q are one orientation. With
// r = log(q_goal^-1 q), e = r - psi and J the left Jacobian of the exponential, omega = R(q_goal) J(r) (dpsi/dt - rate e):
// e falls as exp(-orientation_rate t). NaN in gives NaN out, and so does q = 0.
inline void velocity(const double* x, const double* q, double* v, double* omega) noexcept {{
  velocity(x, v);
  constexpr double inverse_goal[4] = {{{1}}}, to_data[9] = {{{2}}};
  const detail::Normalised<double> at(x);
  double dz[dimension], target[3], change[3];
  for (int i = 0; i < dimension; ++i) dz[i] = v[i] / position_scale;
  detail::psi_along(at.z, dz, target, change);
  const double part[4] = {{{0}}};
  const double norm =
      std::sqrt(part[0] * part[0] + part[1] * part[1] + part[2] * part[2] + part[3] * part[3]);
  const double w = part[0] / norm, a = part[1] / norm, b = part[2] / norm, c = part[3] / norm;
  const double* g = inverse_goal;
  const double real = g[0] * w - g[1] * a - g[2] * b - g[3] * c;
  const double imaginary[3] = {{g[0] * a + g[1] * w + g[2] * c - g[3] * b, g[0] * b - g[1] * c + g[2] * w + g[3] * a,
                               g[0] * c + g[1] * b - g[2] * a + g[3] * w}};
  const double sine = std::sqrt(imaginary[0] * imaginary[0] + imaginary[1] * imaginary[1] + imaginary[2] * imaginary[2]);
  const double cosine = std::fabs(real);
  const double share = (sine < 1e-8 ? 2 / cosine : 2 * std::atan2(sine, cosine) / sine) * (real < 0 ? -1 : 1);
  double r[3], rate[3];
  for (int i = 0; i < 3; ++i) {{
    r[i] = share * imaginary[i];
    rate[i] = change[i] - orientation_rate * (r[i] - target[i]);
  }}
  const double square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2], angle = std::sqrt(square);
  const bool small = angle < 1e-4;
  const double first = small ? 0.5 - square / 24 : (1 - std::cos(angle)) / square;
  const double second = small ? 1.0 / 6 - square / 120 : (angle - std::sin(angle)) / (square * angle);
  const double once[3] = {{r[1] * rate[2] - r[2] * rate[1], r[2] * rate[0] - r[0] * rate[2],
                          r[0] * rate[1] - r[1] * rate[0]}};
  const double twice[3] = {{r[1] * once[2] - r[2] * once[1], r[2] * once[0] - r[0] * once[2],
                           r[0] * once[1] - r[1] * once[0]}};
  for (int i = 0; i < 3; ++i) {{
    omega[i] = 0;
    for (int j = 0; j < 3; ++j) omega[i] += to_data[3 * i + j] * (rate[j] + first * once[j] + second * twice[j]);
  }}
}}

)";

constexpr const char* kMotion = R"(// The motion as a type, for templates (passive_controller.h).
struct Motion {{
  static constexpr int dimension = {0}::dimension;
  static constexpr double execution_speed = {0}::execution_speed, disturbance_margin = {0}::disturbance_margin;
  static void velocity(const double* x, double* v) noexcept {{ {0}::velocity(x, v); }}
  static bool in_workspace(const double* x) noexcept {{ return {0}::in_workspace(x); }}
  static bool safe(const double* x) noexcept {{ return {0}::safe(x); }}
}};

}}  // namespace {0}
)";

// For states (x, s) instead.
constexpr const char* kPhase =
    R"(// The motion with its phase: a control loop makes one at the start, and calls step() once a period.
struct PhasedMotion {{
  static constexpr int places = dimension - 1;  // coordinates of a position
  double s = phase_start;

  // v [places], in `unit` per second, at the position x [places]; then s moves on by `period` seconds (Euler's method).
  void step(const double* x, double period, double* v) noexcept {{
    double state[dimension], rate[dimension];
    for (int i = 0; i < places; ++i) state[i] = x[i];
    state[places] = s;
    velocity(state, rate);
    for (int i = 0; i < places; ++i) v[i] = rate[i];
    s += period * rate[places];
  }}

  // Whether (x, s) lies in the safe set. False for NaN.
  bool safe(const double* x) const noexcept {{
    double state[dimension];
    for (int i = 0; i < places; ++i) state[i] = x[i];
    state[places] = s;
    return {0}::safe(state);
  }}
}};

}}  // namespace {0}
)";

// velocity(x, q, v, omega).
void write_orientation(Text& text, const PolicyInfo& info) {
  const Eigen::Vector4d goal = goal_orientation_of(info);
  std::vector<std::string> parts, inverted, matrix;
  for (const Eigen::Index place : places_in(info.quaternion_order))
    parts.push_back(fmt::format("q[{}]", place));
  for (const double part : inverse(goal)) inverted.push_back(literal(part, false));
  const Points rotation = rotation_matrix(goal);
  for (Eigen::Index i = 0; i < rotation.size(); ++i) matrix.push_back(literal(rotation.data()[i], false));
  put(text, kOrientation, fmt::join(parts, ", "), fmt::join(inverted, ", "), fmt::join(matrix, ", "));
}

}  // namespace

HeaderPrecision header_precision_from(std::string_view name) {
  if (name == "float") return HeaderPrecision::float32;
  if (name == "double") return HeaderPrecision::float64;
  fail("precision: found \"{}\", expected float or double", name);
}

std::string policy_namespace(const std::string& path) {
  std::string space = "policy_";
  for (const char c : std::filesystem::path(path).stem().string()) {
    space += std::isalnum(static_cast<unsigned char>(c)) && static_cast<unsigned char>(c) < 0x80 ? c : '_';
  }
  return space;
}

std::string cpp_header(const Policy& policy, HeaderPrecision precision, const std::string& space,
                       const std::optional<SceneRange>& range) {
  const bool single = precision == HeaderPrecision::float32;
  Text text;
  write_head(text, space);
  write_constants(text, policy.info, single);
  for (const char* source : {kVectors, simd_exponential_source, policy_kernels_source}) {
    text.append(std::string_view(source));
    put(text, "\n");
  }
  NetworkSource(text, "f", policy.networks.f, single).write_all();
  NetworkSource(text, "V", policy.networks.V, false).write_all();
  NetworkSource(text, "B", policy.networks.B, false).write_all();
  if (policy.orientation) {
    NetworkSource psi(text, "psi", policy.orientation->psi, false);
    psi.write_all();
    psi.write_derivative();
  }
  const bool shielded = policy.info.shielded == 1;
  if (shielded) NetworkSource(text, "B", policy.networks.B, false).write_gradient();
  const bool projected = policy.networks.is_projected();
  if (projected) NetworkSource(text, "V", policy.networks.V, false).write_gradient();
  put(text, kInterface, single ? "float" : "double",
      projected ? fmt::format(kProjectedVelocity, literal(policy.networks.decay, false)) : kVelocity);
  if (policy.orientation) write_orientation(text, policy.info);
  if (shielded) put(text, "{}", kShield);
  if (range) put(text, "{}", displaced_source(policy, *range));
  if (policy.info.phase_start > 0.0)
    put(text, kPhase, space);
  else
    put(text, kMotion, space);
  return fmt::to_string(text);
}

}  // namespace s2nnds
