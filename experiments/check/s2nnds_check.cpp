// SPDX-License-Identifier: BSD-3-Clause
// s2nnds-check RUN.h5 [POLICY ...]: checks the certificate of a run file with no code of the program that made it.
#include <hdf5.h>
#include <mpfr.h>
#include <toml++/toml.h>

#include <algorithm>
#include <atomic>
#include <cfenv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

[[noreturn]] void fail(const std::string& found) { throw std::runtime_error(found); }

// All arithmetic of this program runs while the processor rounds upward, on each thread. An interval is kept as its upper
// bound and the negative of its lower bound, so that rounding upward moves both outward.
void round_up() {
  std::fesetenv(FE_DFL_ENV);  // no flush to zero
  std::fesetround(FE_UPWARD);
}
constexpr int lanes = 8;  // boxes side by side
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double))));
Lanes all_lanes(double x) { return Lanes{x, x, x, x, x, x, x, x}; }
Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
Lanes magnitude(Lanes a) { return a < 0.0 ? -a : a; }
double larger(double a, double b) { return a > b ? a : b; }

// {x : -minus_lower <= x <= upper}; T is double or Lanes.
template <typename T>
struct Interval {
  T upper = T{}, minus_lower = T{};
  T size() const { return larger(larger(upper, minus_lower), T{}); }  // above |x|
  friend Interval operator-(const Interval& a) { return {a.minus_lower, a.upper}; }
  friend Interval operator+(const Interval& a, const Interval& b) {
    return {a.upper + b.upper, a.minus_lower + b.minus_lower};
  }
  friend Interval operator-(const Interval& a, const Interval& b) { return a + (-b); }
  friend Interval operator*(const Interval& a, const Interval& b) {
    const T au = a.upper, al = a.minus_lower, bu = b.upper, bl = b.minus_lower;  // al and bl are negated
    return {larger(larger(au * bu, -au * bl), larger(-al * bu, al * bl)),
            larger(larger(-au * bu, au * bl), larger(al * bu, -al * bl))};
  }
};
template <typename T>
Interval<T> point(T x) {
  return {x, -x};
}
using Number = Interval<double>;
using Row = Interval<Lanes>;

Number operator/(const Number& a, const Number& b) {
  if (!(-b.minus_lower > 0.0 || b.upper < 0.0)) return {INFINITY, INFINITY};
  return a * Number{1.0 / -b.minus_lower, -1.0 / b.upper};
}

// Encloses tanh by a table of values that MPFR rounded down and up, and Taylor's theorem in between.
class Tanh {
 public:
  Tanh() {
    mpfr_t z, t;
    mpfr_inits2(53, z, t, static_cast<mpfr_ptr>(nullptr));
    for (int k = 0; k <= static_cast<int>(2 * reach / spacing); ++k) {
      mpfr_set_d(z, k * spacing - reach,
                 MPFR_RNDN);  // exact: spacing and reach are sums of few powers of two
      mpfr_tanh(t, z, MPFR_RNDU);
      const double upper = mpfr_get_d(t, MPFR_RNDU);
      mpfr_tanh(t, z, MPFR_RNDD);
      table_.push_back({upper, -mpfr_get_d(t, MPFR_RNDD)});
    }
    mpfr_clears(z, t, static_cast<mpfr_ptr>(nullptr));
  }
  Number operator()(const Number& z) const {
    const double low = -z.minus_lower, high = z.upper;
    if (!(low <= high)) return {NAN, NAN};
    if (low > reach) return {1.0, table_.back().minus_lower};
    if (high < -reach) return {table_.front().upper, 1.0};
    if (!(high - low < spacing) || low < -reach || high > reach) return {1.0, 1.0};
    const auto k = static_cast<std::size_t>(std::lround((0.5 * (low + high) + reach) / spacing));
    const Number one = point(1.0), t = table_[k], square = t * t, first = one - square;
    const Number second = point(-2.0) * t * first, third = first * (point(6.0) * square - point(2.0));
    const Number d = z - point(double(k) * spacing - reach), d2 = d * d;
    // The fourth derivative is below 4.1, and 4.1 / 24 < 0.171.
    const Number sixth{0.16666666666666669, -0.16666666666666665}, rest = point(0.171) * d2 * d2;
    return t + first * d + point(0.5) * second * d2 + sixth * third * d2 * d +
           Number{rest.size(), rest.size()};
  }

 private:
  static constexpr double spacing = 1.0 / 512, reach = 20.0;
  std::vector<Number> table_;  // at -reach, -reach + spacing, ...
};

// Eight boxes |x - center| <= half; centres are doubles, half-widths are rounded up.
struct Boxes {
  std::vector<Lanes> center, half;  // [n]
};

// A mean-value form of one quantity on each box: it lies in value + slope . (x - center) + [-rest, rest].
struct Form {
  Row value;
  std::vector<Row> slope;  // [n]
  Lanes rest = all_lanes(0.0);

  // Above |slope . (x - center)| + rest.
  Lanes spread(const Boxes& boxes) const {
    Lanes sum = rest;
    for (std::size_t d = 0; d < slope.size(); ++d) sum += slope[d].size() * boxes.half[d];
    return sum;
  }
  Row range(const Boxes& boxes) const { return value + Row{spread(boxes), spread(boxes)}; }
};
struct Layer {
  std::vector<std::vector<double>> weight;  // [out][in]
  std::vector<double> bias;                 // [out] or empty
  bool tanh = false;                        // else the identity
};

// As the run file has it: N(x), N(x) - N(0) or |N(x) - N(0)|^2 + quadratic |x|^2.
struct Network {
  std::vector<Layer> layers;
  std::string head;
  double quadratic = 0.0;

  std::size_t inputs() const { return layers.front().weight.front().size(); }
  std::size_t outputs() const { return layers.back().weight.size(); }
};

Row row(const Number& x) { return {all_lanes(x.upper), all_lanes(x.minus_lower)}; }

// y += w x, w a number.
void add_multiple(double w, const Row& x, Row& y) {
  if (w >= 0.0) {
    y.upper += w * x.upper;
    y.minus_lower += w * x.minus_lower;
  } else {
    y.upper += -w * x.minus_lower;
    y.minus_lower += -w * x.upper;
  }
}
void add_multiple(double w, const Form& x, Form& y) {
  add_multiple(w, x.value, y.value);
  for (std::size_t d = 0; d < x.slope.size(); ++d) add_multiple(w, x.slope[d], y.slope[d]);
  y.rest += std::fabs(w) * x.rest;
}
Form zero(std::size_t n) { return {Row{}, std::vector<Row>(n), all_lanes(0.0)}; }

// a b, both forms: the product of the slopes' parts goes to the rest.
void add_product(const Form& a, const Form& b, const Boxes& boxes, Form& sum) {
  const Lanes a_spread = a.spread(boxes), b_spread = b.spread(boxes);
  sum.value = sum.value + a.value * b.value;
  for (std::size_t d = 0; d < a.slope.size(); ++d)
    sum.slope[d] = sum.slope[d] + a.value * b.slope[d] + b.value * a.slope[d];
  sum.rest += a.value.size() * b.rest + b.value.size() * a.rest + a_spread * b_spread;
}

// x itself: forms without rest.
std::vector<Form> position(const Boxes& boxes) {
  std::vector<Form> x;
  for (std::size_t d = 0; d < boxes.center.size(); ++d) {
    x.push_back(zero(boxes.center.size()));
    x[d].value = point(boxes.center[d]);
    x[d].slope[d] = point(all_lanes(1.0));
  }
  return x;
}

// A network whose layers' values, and their rates along a direction, are enclosed by mean-value forms: each neuron's
// form follows from those of the layer before by interval arithmetic and Taylor's theorem.
struct Enclosure {
  const Network& network;
  const Tanh& tanh;
  std::vector<Number> offset = std::vector<Number>(network.outputs());  // N(0), or 0 for the head `plain`

  Enclosure(const Network& of, const Tanh& table) : network(of), tanh(table) {
    if (network.head == "plain") return;
    const std::size_t n = network.inputs();
    const Boxes origin{std::vector<Lanes>(n), std::vector<Lanes>(n)};
    const std::vector<Form> at_zero = outputs(origin);
    for (std::size_t i = 0; i < offset.size(); ++i) {
      const Row range = at_zero[i].range(origin);
      offset[i] = {range.upper[0], range.minus_lower[0]};
    }
  }

  // tanh of z, whose forms become those of the outputs. With t = tanh(z0), its derivatives are 1 - t^2, then 2 t (1 - t^2)
  // and (1 - t^2) (6 t^2 - 2) but for the sign, over the range t +- spread, for the first is at most 1.
  void activate(const Boxes& boxes, std::vector<Form>& z, std::size_t width) const {
    const Row one = point(all_lanes(1.0));
    for (std::size_t i = 0; i < width; ++i) {
      Form& a = z[i];
      const Lanes spread = a.spread(boxes);
      Row t;
      for (int lane = 0; lane < lanes; ++lane) {
        const Number value = tanh({a.value.upper[lane], a.value.minus_lower[lane]});
        t.upper[lane] = value.upper;
        t.minus_lower[lane] = value.minus_lower;
      }
      const Row first = one - t * t, second = row(point(-2.0)) * t * first;
      // |tanh| lies within [least, high]; 1 - least^2 from above, where least^2 may have been rounded up.
      const Lanes most = larger(t.upper, t.minus_lower) + spread, high = most < 1.0 ? most : all_lanes(1.0);
      const Lanes least = larger(-(spread - larger(-t.upper, -t.minus_lower)), all_lanes(0.0));
      const Lanes steepest = -(least * least - 1.0) + 1e-15, bend = 2.0 * high * steepest;
      const Lanes at_high = 6.0 * high * high - 2.0, at_least = 6.0 * least * least - 2.0;
      const Lanes third = steepest * (larger(magnitude(at_high), magnitude(at_least)) + 1e-14);
      const Lanes square = 0.5 * spread * spread;
      if (z.size() > width) {  // sigma'(z) zdot
        Form& p = z[width + i];
        const Lanes rate_spread = p.spread(boxes), rate_size = p.value.size() + rate_spread;
        const Row cross = second * p.value;
        p.rest = first.size() * p.rest + cross.size() * a.rest + second.size() * spread * rate_spread +
                 (third < 2.0 ? third : all_lanes(2.0)) * square * rate_size;
        for (std::size_t d = 0; d < p.slope.size(); ++d) p.slope[d] = first * p.slope[d] + cross * a.slope[d];
        p.value = first * p.value;
      }
      a.rest = first.size() * a.rest + (bend < 0.77 ? bend : all_lanes(0.77)) * square;
      for (Row& slope : a.slope) slope = first * slope;
      a.value = t;
    }
  }

  // Outputs [m] of the layers, less the offset, and after them their rates while x moves along `direction` [n].
  std::vector<Form> outputs(const Boxes& boxes, const std::vector<Form>& direction = {}) const {
    std::vector<Form> a = position(boxes);
    const std::size_t n = a.size(), streams = direction.empty() ? 1 : 2;
    a.insert(a.end(), direction.begin(), direction.end());
    for (const Layer& layer : network.layers) {
      const std::size_t width = layer.weight.size(), inputs = layer.weight.front().size();
      std::vector<Form> z(streams * width, zero(n));
      for (std::size_t at = 0; at < z.size(); ++at) {
        const std::size_t i = at % width, first = at < width ? 0 : inputs;
        if (at < width && !layer.bias.empty()) z[at].value = row(point(layer.bias[i]));
        for (std::size_t k = 0; k < inputs; ++k) add_multiple(layer.weight[i][k], a[first + k], z[at]);
      }
      if (layer.tanh) activate(boxes, z, width);
      a = std::move(z);
    }
    for (std::size_t i = 0; i < offset.size(); ++i) a[i].value = a[i].value - row(offset[i]);
    return a;
  }

  // The scalar with its head; with a direction its rate.
  Form scalar(const Boxes& boxes, const std::vector<Form>& direction = {}) const {
    const std::vector<Form> u = outputs(boxes, direction), x = position(boxes);
    const std::size_t m = offset.size(), other = direction.empty() ? 0 : m;
    if (network.head != "squared_norm") return u[other];
    Form sum = zero(x.size()), square = sum, result = sum;
    for (std::size_t i = 0; i < m; ++i) add_product(u[i], u[other + i], boxes, sum);
    for (std::size_t d = 0; d < x.size(); ++d)
      add_product(x[d], direction.empty() ? x[d] : direction[d], boxes, square);
    add_multiple(network.quadratic, square, sum);
    add_multiple(direction.empty() ? 1.0 : 2.0, sum, result);
    return result;
  }
};

// ---- Sets

struct Box {
  std::vector<double> lower, upper;  // [n]
};

// A set {level <= 0}, as a function that encloses the level over a box [n].
using Region = std::function<Number(const std::vector<Number>&)>;

std::vector<double> list(const toml::table& table, const char* key) {
  std::vector<double> found;
  const toml::array* array = table[key].as_array();
  if (array == nullptr) fail(std::string("found no list ") + key);
  for (const toml::node& node : *array) found.push_back(node.value<double>().value());
  return found;
}
double scalar(const toml::table& table, const char* key) {
  if (!table[key].is_number()) fail(std::string("found no number ") + key);
  return *table[key].value<double>();
}
Number maximum(const Number& a, const Number& b) {
  return {larger(a.upper, b.upper), -larger(-a.minus_lower, -b.minus_lower)};
}

// sum ((x_i - center_i) / semi_axis_i)^2 - 1
Region ellipsoid(const std::vector<double>& center, const std::vector<double>& semi_axes) {
  return [=](const std::vector<Number>& x) {
    Number sum = point(-1.0);
    for (std::size_t d = 0; d < center.size(); ++d) {
      const Number u = (x[d] - point(center[d])) / point(semi_axes.at(d));
      const double least = larger(larger(-u.upper, -u.minus_lower), 0.0);  // of |u|
      sum = sum + Number{(u * u).upper, -least * least};
    }
    return sum;
  };
}

// From its TOML table. Throws on a kind that this program does not know.
Region read_region(const toml::table& table) {
  const std::string type = table["type"].value_or(std::string("none"));
  if (table["inflate"].value_or(0.0) != 0.0)
    fail("found an inflated region, which this program cannot check");
  if (type == "none") return [](const std::vector<Number>&) { return Number{INFINITY, -INFINITY}; };
  if (type == "ball") {
    const std::vector<double> center = list(table, "center");
    return ellipsoid(center, std::vector<double>(center.size(), scalar(table, "radius")));
  }
  if (type == "ellipsoid") return ellipsoid(list(table, "center"), list(table, "semi_axes"));
  if (type == "box") {
    return [lower = list(table, "lower"), upper = list(table, "upper")](const std::vector<Number>& x) {
      Number most{-INFINITY, INFINITY};
      for (std::size_t d = 0; d < x.size(); ++d) {
        if (lower.at(d) > -INFINITY) most = maximum(most, point(lower[d]) - x[d]);
        if (upper.at(d) < INFINITY) most = maximum(most, x[d] - point(upper[d]));
      }
      return most;
    };
  }
  if (type == "halfspace") {
    return [normal = list(table, "normal"), offset = scalar(table, "offset")](const std::vector<Number>& x) {
      Number sum = point(-offset);
      for (std::size_t d = 0; d < x.size(); ++d) sum = sum + point(normal.at(d)) * x[d];
      return sum;
    };
  }
  std::vector<Region> parts;
  if (const toml::array* of = table["of"].as_array())
    for (const toml::node& node : *of) parts.push_back(read_region(*node.as_table()));
  if (parts.empty() || (type != "union" && type != "intersection" && type != "complement"))
    fail("found a region of type " + type + ", which this program cannot check");
  return [type, parts](const std::vector<Number>& x) {  // the least, the greatest, the negated level
    Number level = parts[0](x);
    for (std::size_t i = 1; i < parts.size(); ++i)
      level = type == "union" ? -maximum(-level, -parts[i](x)) : maximum(level, parts[i](x));
    return type == "complement" ? -level : level;
  };
}

// ---- Files

// What is to be checked, as a run file states it.
struct Claim {
  Network f, V, B;
  Box workspace, inner;  // normalised: X, and the part of it within which {B <= 0} must lie
  double level_band = 0.0;
  Region initial, unsafe;
  std::vector<double> goal;  // [n] both regions stand in x = goal + scale z, z normalised
  double scale = 1.0;
  std::string text;  // the file's own words for the problem
};

class File {
 public:
  explicit File(const std::string& path) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file_ < 0) fail("found no HDF5 file; expected a run file");
  }
  ~File() { H5Fclose(file_); }
  std::string text(const std::string& group, const std::string& name) const {
    char* found = nullptr;
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    read(group, name, type, &found);
    return found != nullptr ? found : "";
  }
  double number(const std::string& group, const std::string& name) const {
    double found = NAN;
    read(group, name, H5T_NATIVE_DOUBLE, &found);
    return found;
  }
  std::vector<double> array(const std::string& item, bool optional = false) const {
    if (optional && H5Lexists(file_, item.c_str(), H5P_DEFAULT) <= 0) return {};
    const hid_t set = H5Dopen2(file_, item.c_str(), H5P_DEFAULT), space = H5Dget_space(set);
    std::vector<double> found(set < 0 ? 0 : static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    if (found.empty() || H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, found.data()) < 0)
      fail("found no numbers " + item);
    return found;
  }

 private:
  void read(const std::string& group, const std::string& name, hid_t type, void* value) const {
    const hid_t found = H5Aopen_by_name(file_, group.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    if (found < 0 || H5Aread(found, type, value) < 0) fail("found no " + group + " " + name);
  }
  hid_t file_;
};

Network read_network(const File& file, const std::string& group) {
  const auto fits = [](double w) { return std::fabs(w) <= 1e6; };
  Network network{{}, file.text(group, "head"), file.number(group, "quadratic")};
  for (int k = 0; k < static_cast<int>(file.number(group, "layers")); ++k) {
    const std::string index = std::to_string(k), activation = file.text(group, "activation_" + index);
    if (activation != "tanh" && activation != "identity")
      fail("found the activation " + activation + ", which this program cannot check");
    Layer layer{{}, {}, activation == "tanh"};
    const std::vector<double> weight = file.array(group + "/weight_" + index);
    layer.bias = file.array(group + "/bias_" + index, true);
    // Without a bias, the number of rows follows from the layer before.
    const std::size_t inputs = k == 0 ? static_cast<std::size_t>(file.number("/data", "dimension"))
                                      : network.layers.back().weight.size();
    for (std::size_t i = 0; i + inputs <= weight.size(); i += inputs)
      layer.weight.emplace_back(weight.begin() + long(i), weight.begin() + long(i + inputs));
    if (layer.weight.size() * inputs != weight.size() ||
        (!layer.bias.empty() && layer.bias.size() != layer.weight.size()) ||
        !std::all_of(weight.begin(), weight.end(), fits) ||
        !std::all_of(layer.bias.begin(), layer.bias.end(), fits))
      fail("found weights of " + group + " that do not fit together");
    network.layers.push_back(std::move(layer));
  }
  return network;
}

// Throws one line on a file that is no run file or that this program cannot check.
Claim read_claim(const std::string& path) {
  const File file(path);
  Claim claim;
  claim.f = read_network(file, "/networks/f");
  claim.V = read_network(file, "/networks/V");
  claim.B = read_network(file, "/networks/B");
  claim.text = file.text("/certificate", "scope");
  const toml::table scope = toml::parse(claim.text);
  const toml::table& problem = *scope["problem"].as_table();
  claim.workspace = {list(problem, "workspace_lower"), list(problem, "workspace_upper")};
  claim.inner = {list(problem, "contained_lower"), list(problem, "contained_upper")};
  claim.level_band = scalar(problem, "level_band");
  claim.initial = read_region(*problem["initial"].as_table());
  claim.unsafe = read_region(*problem["unsafe"].as_table());
  const toml::table& frame = *scope["frame"].as_table();
  // With weights and coordinates of at most 1e6 nothing overflows but the forms' rests, and those are only added to.
  for (std::size_t d = 0; d < claim.workspace.lower.size(); ++d) {
    const double low = claim.workspace.lower[d], high = claim.workspace.upper.at(d);
    if (!(low < 0.0 && high > 0.0 && high - low <= 1e6 && claim.inner.lower.at(d) >= low &&
          claim.inner.upper.at(d) <= high))
      fail("found a workspace without the goal, or beyond 1e6, or not around the inner one");
  }
  claim.goal.assign(claim.workspace.lower.size(), 0.0);
  if (problem["frame"].value_or(std::string()) == "data") {
    claim.goal = list(frame, "goal");
    claim.scale = scalar(frame, "position_scale");
  }
  if (claim.f.inputs() != claim.workspace.lower.size() || claim.f.outputs() != claim.f.inputs() ||
      claim.V.inputs() != claim.f.inputs() || claim.B.inputs() != claim.f.inputs() || claim.B.outputs() != 1)
    fail("found networks and a workspace of different dimensions");
  return claim;
}

// Whether the exported policy holds every bias, row or column of weights of f, V and B: as doubles or floats in memory's form (ONNX, TorchScript, pt2) or as numbers in a text (C++ header).
bool carries_weights(const std::string& policy, const Claim& claim) {
  std::fesetround(FE_TONEAREST);  // as whoever rounded them to float
  std::ifstream file(policy, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const auto image = [](const auto& of) {
    return std::string(reinterpret_cast<const char*>(of.data()), of.size() * sizeof(of[0]));
  };
  if (bytes.find('\0') == bytes.npos) {
    std::vector<float> numbers;
    char* end = nullptr;
    for (const char* at = bytes.c_str(); *at != '\0'; at = end > at ? end : at + 1) {
      const double number = std::strtod(at, &end);
      if (end > at) numbers.push_back(static_cast<float>(number));
    }
    bytes = image(numbers);
  }
  const auto holds = [&](const std::vector<double>& values) {
    const std::vector<float> rounded(values.begin(), values.end());
    return values.empty() || bytes.find(image(values)) != bytes.npos ||
           bytes.find(image(rounded)) != bytes.npos;
  };
  for (const Network* network : {&claim.f, &claim.V, &claim.B}) {
    for (const Layer& layer : network->layers) {
      std::vector<std::vector<double>> columns(layer.weight.front().size());
      for (const std::vector<double>& row : layer.weight)
        for (std::size_t k = 0; k < row.size(); ++k) columns[k].push_back(row[k]);
      const auto all = [&](const auto& lines) { return std::all_of(lines.begin(), lines.end(), holds); };
      if (!holds(layer.bias) || !(all(layer.weight) || all(columns))) return false;
    }
  }
  return true;
}

// ---- The proof
constexpr double least_width = 1e-9, largest_cube = 0.08;
// A condition: whether it asks anything of a box, and what must be negative there, from above.
struct Condition {
  std::function<bool(const Box&)> asks;
  std::function<Lanes(const Boxes&)> residual;
};

Boxes side_by_side(const std::vector<Box>& boxes) {
  const std::size_t n = boxes.front().lower.size();
  Boxes tile{std::vector<Lanes>(n), std::vector<Lanes>(n)};
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const Box& box = boxes[lane < boxes.size() ? lane : 0];
    for (std::size_t d = 0; d < n; ++d) {
      const double middle = 0.5 * box.lower[d] + 0.5 * box.upper[d];
      tile.center[d][lane] = middle;
      tile.half[d][lane] = larger(box.upper[d] - middle, middle - box.lower[d]);
    }
  }
  return tile;
}

// Two boxes that share a face, so that no point is lost: halves along the widest side, of width `width`.
std::vector<Box> halves(const Box& box, double& width) {
  std::size_t axis = 0;
  const auto side = [&](std::size_t d) { return box.upper[d] - box.lower[d]; };
  for (std::size_t d = 1; d < box.lower.size(); ++d) axis = side(d) > side(axis) ? d : axis;
  width = side(axis);
  std::vector<Box> parts = {box, box};
  parts[0].upper[axis] = parts[1].lower[axis] = 0.5 * box.lower[axis] + 0.5 * box.upper[axis];
  return parts;
}

// Shows the condition on boxes that cover `whole`, by two threads, and counts them. Returns a box that stays open, or none.
Box cover(const Box& whole, const Condition& condition, std::atomic<long>& boxes) {
  std::vector<Box> start = {whole};
  while (start.size() < 4096) {
    std::vector<Box> parts;
    double width = 0.0;
    for (const Box& box : start)
      for (Box& part : halves(box, width)) parts.push_back(std::move(part));
    start = std::move(parts);
  }
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> open = false;
  Box left;
  const auto work = [&] {
    round_up();
    std::vector<Box> stack;
    while (!open) {
      std::vector<Box> tile;
      while (tile.size() < lanes) {
        if (stack.empty()) {
          const std::size_t mine = next++;
          if (mine >= start.size()) break;
          stack.push_back(start[mine]);
        }
        if (condition.asks(stack.back())) tile.push_back(stack.back());
        stack.pop_back();
        ++boxes;
      }
      if (tile.empty()) return;
      const Lanes residual = condition.residual(side_by_side(tile));
      for (std::size_t i = 0; i < tile.size(); ++i) {
        if (residual[i] < 0.0 && residual[i] > -1e100) continue;  // nor NaN, nor what may have overflowed
        double width = 0.0;
        for (Box& part : halves(tile[i], width)) stack.push_back(std::move(part));
        if (width < least_width && !open.exchange(true)) left = tile[i];
      }
    }
  };
  std::thread other(work);
  work();
  other.join();
  return left;
}

// For |x|_inf <= half, f(x) = A x and N(x) - N(0) = P x with A, P in the Jacobians' enclosures, so that Vdot = x' M x with
// M = 2 (P' J + quadratic I) A. Negative definite if every pivot of -(M + M') is positive.
bool decreases_around_goal(const Enclosure& f, const Enclosure& V, double half) {
  const std::size_t n = f.network.inputs();
  const Boxes cube{std::vector<Lanes>(n), std::vector<Lanes>(n, all_lanes(half))};
  const auto jacobian = [&](const Enclosure& function) {
    const std::size_t m = function.network.outputs();
    std::vector<std::vector<Number>> j(m, std::vector<Number>(n));
    for (std::size_t k = 0; k < n; ++k) {
      std::vector<Form> direction(n, zero(n));
      direction[k].value = point(all_lanes(1.0));
      const std::vector<Form> rates = function.outputs(cube, direction);
      for (std::size_t i = 0; i < m; ++i) {
        const Row range = rates[m + i].range(cube);
        j[i][k] = {range.upper[0], range.minus_lower[0]};
      }
    }
    return j;
  };
  const auto A = jacobian(f), P = jacobian(V);
  std::vector<std::vector<Number>> G(n, std::vector<Number>(n)), S = G, M = G;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k) {
      if (i == k) G[i][k] = point(V.network.quadratic);
      for (const auto& row : P) G[i][k] = G[i][k] + row[i] * row[k];
    }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t l = 0; l < n; ++l) M[i][k] = M[i][k] + G[i][l] * A[l][k];
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k) S[i][k] = -(M[i][k] + M[k][i]);
  for (std::size_t k = 0; k < n; ++k) {
    if (!(-S[k][k].minus_lower > 0.0)) return false;
    for (std::size_t i = k + 1; i < n; ++i)
      for (std::size_t l = k + 1; l < n; ++l) S[i][l] = S[i][l] - S[i][k] * S[k][l] / S[k][k];
  }
  return true;
}

bool meets(const Claim& claim, const Region& region, const Box& box) {
  std::vector<Number> x;
  for (std::size_t d = 0; d < box.lower.size(); ++d)
    x.push_back(point(claim.goal[d]) + point(claim.scale) * Number{box.upper[d], -box.lower[d]});
  return !(-region(x).minus_lower > 0.0);
}

// What lies outside of the inner box, or on the workspace's boundary.
bool meets_margin(const Claim& claim, const Box& box) {
  for (std::size_t d = 0; d < box.lower.size(); ++d)
    if (!(box.upper[d] < claim.inner.upper[d] && box.lower[d] > claim.inner.lower[d])) return true;
  return false;
}

bool is_initial_inside(const Claim& claim) {
  const std::size_t n = claim.workspace.lower.size();
  for (std::size_t d = 0; d < n; ++d) {
    Box above{std::vector<double>(n, -1e300), std::vector<double>(n, 1e300)}, below = above;
    above.lower[d] = std::nextafter(claim.workspace.upper[d], INFINITY);
    below.upper[d] = std::nextafter(claim.workspace.lower[d], -INFINITY);
    if (meets(claim, claim.initial, above) || meets(claim, claim.initial, below)) return false;
  }
  return true;
}

bool run(const std::string& path, const std::vector<std::string>& policies) {
  round_up();
  const Claim claim = read_claim(path);
  const Tanh tanh;
  const Enclosure f(claim.f, tanh), V(claim.V, tanh), B(claim.B, tanh);
  std::printf("%s\n%s\n", path.c_str(), claim.text.c_str());
  bool all = true;
  const auto say = [&](const std::string& what, bool holds, long boxes = 0) {
    std::printf("%-50s %s", what.c_str(), holds ? "holds" : "NOT SHOWN");
    std::printf(boxes > 0 ? ", %ld boxes\n" : "\n", boxes);
    std::fflush(stdout);
    all = all && holds;
  };
  say("f(0) = 0, by its form", claim.f.head == "zero_at_origin" && claim.B.head == "plain");
  say("V(0) = 0 and V > 0 elsewhere, by its form", claim.V.head == "squared_norm" && claim.V.quadratic > 0.0);
  if (!all) return false;
  double cube = largest_cube;  // Vdot < 0 for 0 < |x|_inf <= cube
  while (cube > 0.0 && !decreases_around_goal(f, V, cube)) cube = cube > 1e-7 ? 0.5 * cube : 0.0;
  const auto ask = [&](const char* what, const Condition& condition) {
    std::atomic<long> boxes = 0;
    const Box open = cover(claim.workspace, condition, boxes);
    say(what, open.lower.empty(), boxes);
    for (const double x : open.lower) std::printf("  open at %.9g\n", x);
  };
  const auto away = [&](const Box& box) {
    const auto far = [&](double x) { return std::fabs(x) > cube; };
    return std::any_of(box.lower.begin(), box.lower.end(), far) ||
           std::any_of(box.upper.begin(), box.upper.end(), far);
  };
  const auto barrier = [&](const Boxes& boxes) { return B.scalar(boxes).range(boxes); };
  const auto positive = [&](const Boxes& boxes) { return barrier(boxes).minus_lower; };
  const auto negative = [&](const Boxes& boxes) { return barrier(boxes).upper; };
  const auto rate = [&](const Enclosure& of, const Boxes& x) {
    return of.scalar(x, f.outputs(x)).range(x).upper;
  };
  const auto rate_in_band = [&](const Boxes& boxes) {
    const Row value = barrier(boxes);
    const auto beyond = (-value.minus_lower > claim.level_band) | (-value.upper > claim.level_band);
    return beyond ? all_lanes(-1.0) : rate(B, boxes);
  };
  ask("Vdot < 0 but at the goal", {away, [&](const Boxes& boxes) { return rate(V, boxes); }});
  ask("B < 0 on the initial set",
      {[&](const Box& box) { return meets(claim, claim.initial, box); }, negative});
  ask("B > 0 on the unsafe set", {[&](const Box& box) { return meets(claim, claim.unsafe, box); }, positive});
  ask("B > 0 on the workspace's margin and boundary",
      {[&](const Box& box) { return meets_margin(claim, box); }, positive});
  ask("Bdot < 0 where |B| <= the band", {[](const Box&) { return true; }, rate_in_band});
  const std::vector<double> origin(claim.f.inputs());
  say("B(0) <= 0", barrier(side_by_side({Box{origin, origin}})).upper[0] <= 0.0);
  say("the initial set lies in the workspace", is_initial_inside(claim));
  if (all)
    std::printf(
        "Checked: every motion xdot = f(x) that starts in {B <= 0} stays in it for ever, never touches the "
        "unsafe set, and converges to the goal; the initial set lies in {B <= 0}.\n");
  for (const std::string& policy : policies) say("weights in " + policy, carries_weights(policy, claim));
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty() || arguments[0].starts_with("-")) {
    std::fprintf(stderr, "usage: s2nnds-check RUN.h5 [POLICY ...]\n");
    return 2;
  }
  try {
    return run(arguments[0], {arguments.begin() + 1, arguments.end()}) ? 0 : 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "s2nnds-check: %s: %s\n", arguments[0].c_str(), error.what());
    return 2;
  }
}
