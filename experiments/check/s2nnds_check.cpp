// SPDX-License-Identifier: BSD-3-Clause
// s2nnds-check FILE [POLICY ...]: checks the certificate of a run file, or of the proof that `verify --artifact` wrote,
// with no code of the program that made it.
#include <hdf5.h>
#include <mpfr.h>
#include <openssl/evp.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {
using std::fabs, std::max, std::min, std::size_t, std::string;
using Numbers = std::vector<double>;
[[noreturn]] void fail(const string& found) { throw std::runtime_error("found " + found); }
// All arithmetic of this program runs while the processor rounds upward, on each thread. An interval is kept as its upper
// bound and the negative of its lower bound, so that rounding upward moves both outward.
void round_up() {
  std::fesetenv(FE_DFL_ENV);  // no flush to zero
  std::fesetround(FE_UPWARD);
}
struct Interval {  // -minus_lower <= x <= upper
  double upper = 0.0, minus_lower = 0.0;
  double size() const { return max(upper, minus_lower); }  // |x| is at most this
};
using Intervals = std::vector<Interval>;
Interval at(double x) { return {x, -x}; }
Interval around_zero(double size) { return {size, size}; }
Interval operator-(Interval a) { return {a.minus_lower, a.upper}; }
Interval operator+(Interval a, Interval b) { return {a.upper + b.upper, a.minus_lower + b.minus_lower}; }
Interval operator-(Interval a, Interval b) { return a + (-b); }
Interval operator*(Interval a, Interval b) {
  const double au = a.upper, al = a.minus_lower, bu = b.upper, bl = b.minus_lower;  // al and bl are negated
  return {max(max(au * bu, -au * bl), max(-al * bu, al * bl)),
          max(max(-au * bu, au * bl), max(al * bu, -al * bl))};
}
Interval positive_inverse(Interval a) { return {1.0 / -a.minus_lower, -1.0 / a.upper}; }
Interval maximum(Interval a, Interval b) {
  return {max(a.upper, b.upper), min(a.minus_lower, b.minus_lower)};
}
// y += w x
void add_multiple(double w, Interval x, Interval& y) {
  const double size = fabs(w);
  y.upper += size * (w < 0.0 ? x.minus_lower : x.upper);
  y.minus_lower += size * (w < 0.0 ? x.upper : x.minus_lower);
}
constexpr double spacing = 1.0 / 512, reach = 20.0;
// tanh at -reach, -reach + spacing, ..., reach, rounded down and up by MPFR.
Intervals tanh_table() {
  Intervals table;
  mpfr_t z, t;
  mpfr_inits2(53, z, t, static_cast<mpfr_ptr>(nullptr));
  for (int k = 0; k <= static_cast<int>(2 * reach / spacing); ++k) {
    mpfr_set_d(z, k * spacing - reach, MPFR_RNDN);  // exact: sums of few powers of two
    mpfr_tanh(t, z, MPFR_RNDD);
    const double lower = mpfr_get_d(t, MPFR_RNDD);
    mpfr_tanh(t, z, MPFR_RNDU);
    table.push_back({mpfr_get_d(t, MPFR_RNDU), -lower});
  }
  mpfr_clears(z, t, static_cast<mpfr_ptr>(nullptr));
  return table;
}
// tanh(z), by that table and Taylor's theorem in between.
Interval tanh_range(Interval z) {
  static const Intervals table = tanh_table();
  const double middle = 0.5 * (z.upper - z.minus_lower);
  const size_t k = fabs(middle) <= reach ? std::lround((middle + reach) / spacing) : 0;
  const Interval t = table[k], d = z - at(static_cast<double>(k) * spacing - reach);
  if (!(d.size() <= spacing))
    return {z.upper < -reach ? table.front().upper : 1.0,
            -z.minus_lower > reach ? table.back().minus_lower : 1.0};
  const Interval third{0.33333333333333337, -0.3333333333333333}, d2 = d * d, first = at(1.0) - t * t;
  // The fourth derivative is below 4.1, and 4.1 / 24 < 0.171.
  return t + first * d - t * first * d2 + first * (t * t - third) * d2 * d +
         around_zero(0.171 * d2.upper * d2.upper);
}
struct Box {
  Numbers lower, upper;  // [n]
};
// As the file has it: N(x), N(x) - N(0) or |N(x) - N(0)|^2 + quadratic |x|^2.
struct Layer {
  std::vector<Numbers> weight;  // [out][in]
  Numbers bias;                 // [out] or empty
  bool tanh = false;            // else the identity
};
struct Network {
  string head;
  double quadratic = 0.0;
  std::vector<Layer> layers;
  Intervals offset;  // N(0), or none for the head `plain`
  size_t inputs() const { return layers.front().weight.front().size(); }
  size_t outputs() const { return layers.back().weight.size(); }
};
// A quantity on a box: with d = x - center, it lies in value + slope . d + [-rest, rest], where value and slope enclose it
// and its gradient at the center.
constexpr size_t most_dimensions = 4;
struct Form {
  Interval value;
  std::array<Interval, most_dimensions> slope;  // [n]
  double rest = 0.0;
};
// A computation on a box, step by step: sums with weights, tanh, and `plus` + factor a b.
class Tape {
 public:
  static constexpr size_t zero = 0, one = 1, x = 2;  // the first steps: constants, and the coordinates [n]
  explicit Tape(const Box& box) : n_(box.lower.size()) {
    given(at(0.0));
    given(at(1.0));
    for (size_t d = 0; d < n_; ++d) {
      const double center = 0.5 * box.lower[d] + 0.5 * box.upper[d];
      half_[d] = max(box.upper[d] - center, center - box.lower[d]);
      steps_[given(at(center))].form.slope[d] = at(1.0);
    }
  }
  size_t size() const { return steps_.size(); }
  size_t given(const Interval& value) { return add({Kind::given, {value, {}, {}}}); }
  void subtract(size_t k, Interval c) { steps_[k].form.value = steps_[k].form.value - c; }
  size_t sum(const Numbers& weights, double constant, size_t first) {
    Form y{at(constant), {}, {}};
    for (size_t k = 0; k < weights.size(); ++k) {
      const Form& term = form(first + k);
      add_multiple(weights[k], term.value, y.value);
      for (size_t d = 0; d < n_; ++d) add_multiple(weights[k], term.slope[d], y.slope[d]);
      y.rest += fabs(weights[k]) * term.rest;
    }
    return add({Kind::sum, y, first, 0, 0, {}, &weights});
  }
  // t + t' dz + [-1, 1] max |t''| dz^2 / 2. With t = tanh(z), its derivatives are 1 - t^2, -2 t (1 - t^2) and
  // (1 - t^2) (6 t^2 - 2), below 1, 0.77 and 2; t is within its value at the center +- spread, as the first is at most 1.
  size_t tanh(size_t of) {
    const Form& z = form(of);
    const Interval t = tanh_range(z.value), first = at(1.0) - t * t, second = at(-2.0) * t * first;
    // |tanh| lies within [least, most]; 1 - least^2 from above, where least^2 may have been rounded up.
    const double away = spread(z), most = min(t.size() + away, 1.0);
    const double least = max(-(away - max(-t.upper, -t.minus_lower)), 0.0);
    const double steepest = -(least * least - 1.0) + 1e-15;
    Form y{t, {}, first.size() * z.rest + 0.5 * min(2.0 * most * steepest, 0.77) * away * away};
    for (size_t d = 0; d < n_; ++d) y.slope[d] = first * z.slope[d];
    return add({Kind::tanh, y, of, 0, 0, first, nullptr, second, min(4.0 * steepest, 2.0)});
  }
  size_t product(size_t plus, double factor, size_t a, size_t b) {
    const Form &u = form(a), &v = form(b);
    const Interval f = at(factor), by_u = f * v.value, by_v = f * u.value;
    Form y = form(plus);
    y.value = y.value + by_u * u.value;
    for (size_t d = 0; d < n_; ++d) y.slope[d] = y.slope[d] + by_u * u.slope[d] + by_v * v.slope[d];
    y.rest += by_u.size() * u.rest + by_v.size() * v.rest + f.size() * spread(u) * spread(v);
    return add({Kind::product, y, a, b, plus, f});
  }
  Interval rough_range(size_t y) const { return form(y).value + around_zero(spread(form(y))); }
  const Form& form(size_t k) const { return steps_[k].form; }
  // Let each step be its tangent at the center plus a bend. Then y is its own tangent plus all bends, each times y's derivative
  // at the center by that step. The bends' terms of second order make y's hessian, those of third order are bounded.
  Interval range(size_t y) const {
    Intervals by(steps_.size());  // y's derivative at the center by each step
    by[y] = at(1.0);
    std::array<std::array<Interval, most_dimensions>, most_dimensions> hessian;
    double rest = 0.0;
    // c (u - u at the center) (v - v at the center)
    const auto bend = [&](const Interval& c, const Form& u, const Form& v) {
      for (size_t d = 0; d < n_; ++d) {
        const Interval along = c * u.slope[d], across = c * v.slope[d];
        for (size_t e = d; e < n_; ++e)
          hessian[d][e] = hessian[d][e] + along * v.slope[e] + across * u.slope[e];
      }
      rest += c.size() * (linear(u) * v.rest + linear(v) * u.rest + u.rest * v.rest);
    };
    for (size_t k = y + 1; k-- > x + n_;) {
      const Step& step = steps_[k];
      const Form &u = form(step.a), &v = form(step.b);
      if (step.kind == Kind::sum) {
        for (size_t i = 0; i < step.weights->size(); ++i)
          add_multiple((*step.weights)[i], by[k], by[step.a + i]);
      } else if (step.kind == Kind::tanh) {
        bend(at(0.5) * by[k] * step.second, u, u);
        rest += by[k].size() * step.third_size * spread(u) * spread(u) * spread(u) * 0.16666666666666669;
        by[step.a] = by[step.a] + by[k] * step.first;
      } else if (step.kind == Kind::product) {
        const Interval c = by[k] * step.first;
        bend(c, u, v);
        by[step.a] = by[step.a] + c * v.value;
        by[step.b] = by[step.b] + c * u.value;
        by[step.plus] = by[step.plus] + by[k];
      }
    }
    Interval sum = form(y).value + around_zero(rest);
    for (size_t d = 0; d < n_; ++d) {
      // Of s t + c t^2 on 0 <= t <= h: at h, or at an extremum t <= h, where it is s t / 2.
      const double h = half_[d], s = form(y).slope[d].size() * h;
      const Interval bow = at(0.5) * at(h) * at(h) * hessian[d][d];
      sum = sum + Interval{max(0.5 * s, s + bow.upper), max(0.5 * s, s + bow.minus_lower)};
      for (size_t e = d + 1; e < n_; ++e) sum = sum + around_zero(hessian[d][e].size() * h * half_[e]);
    }
    return sum;
  }

 private:
  enum class Kind { given, sum, tanh, product };
  struct Step {
    Kind kind;
    Form form;
    size_t a = 0, b = 0, plus = 0;  // the steps that it takes; for a sum a is the first of them
    Interval first{};               // tanh's slope at the center, or a product's factor
    const Numbers* weights = nullptr;
    Interval second{};        // tanh's second derivative at the center
    double third_size = 0.0;  // above the size of its third one on the box; it is below 4 (1 - t^2)
  };
  size_t add(const Step& step) { return steps_.push_back(step), size() - 1; }
  double linear(const Form& of) const {  // above |slope . d|
    double sum = 0.0;
    for (size_t d = 0; d < n_; ++d) sum += of.slope[d].size() * half_[d];
    return sum;
  }
  double spread(const Form& of) const { return linear(of) + of.rest; }
  size_t n_;
  std::array<double, most_dimensions> half_{};  // rounded up
  std::vector<Step> steps_;
};
// Puts the network's layers on the tape. Returns the steps of its first output, and of that one's rate while x has the rates
// that begin with step `direction` (0: none).
std::pair<size_t, size_t> apply(const Network& network, Tape& tape, size_t direction = 0) {
  size_t x = Tape::x, p = direction;
  for (const Layer& layer : network.layers) {
    const size_t width = layer.weight.size(), z = tape.size(), rate = p == 0 ? 0 : z + width;
    for (size_t i = 0; i < width; ++i) tape.sum(layer.weight[i], layer.bias.empty() ? 0.0 : layer.bias[i], x);
    for (size_t i = 0; i < width && p != 0; ++i) tape.sum(layer.weight[i], 0.0, p);
    x = z;
    p = rate;
    if (!layer.tanh) continue;
    x = tape.size();
    for (size_t i = 0; i < width; ++i) tape.tanh(z + i);
    if (p == 0) continue;
    p = tape.size() + width;
    for (size_t i = 0; i < width; ++i) tape.product(Tape::one, -1.0, x + i, x + i);
    for (size_t i = 0; i < width; ++i) tape.product(Tape::zero, 1.0, x + width + i, rate + i);
  }
  for (size_t i = 0; i < network.offset.size(); ++i) tape.subtract(x + i, network.offset[i]);
  return {x, p};
}
void find_offset(Network& network) {
  Tape tape({Numbers(network.inputs()), Numbers(network.inputs())});
  const size_t first = apply(network, tape).first, count = network.head == "plain" ? 0 : network.outputs();
  for (size_t i = 0; i < count; ++i) network.offset.push_back(tape.rough_range(first + i));
}
// B on the box.
Interval value_range(const Network& B, const Box& box) {
  Tape tape(box);
  return tape.range(apply(B, tape).first);
}
// The rate of B or V while x moves along f.
Interval rate_range(const Network& of, const Network& f, const Box& box) {
  Tape tape(box);
  const size_t p = apply(f, tape).first, n = f.inputs();
  const auto [u, rate] = apply(of, tape, p);
  if (of.head != "squared_norm") return tape.range(rate);
  size_t y = Tape::zero;
  for (size_t i = 0; i < of.outputs(); ++i) y = tape.product(y, 2.0, u + i, rate + i);
  for (size_t d = 0; d < n; ++d) y = tape.product(y, 2.0 * of.quadratic, Tape::x + d, p + d);
  return tape.range(y);
}
// A set {level <= 0}, as a function that encloses the level over a box [n].
using Region = std::function<Interval(const Intervals&)>;
template <typename T>
const T& need(const toml::table& table, const char* key) {
  const T* found = table[key].as<T>();
  if (found == nullptr) fail(string("no ") + key + " of the expected type");
  return *found;
}
Numbers list(const toml::table& table, const char* key) {
  Numbers found;
  for (const toml::node& node : need<toml::array>(table, key)) found.push_back(node.value<double>().value());
  return found;
}
double scalar(const toml::table& table, const char* key) {
  const std::optional<double> found = table[key].value<double>();
  return found ? *found : throw std::runtime_error(string("found no number ") + key);
}
// From its TOML table. Throws on what this program does not know.
Region read_region(const toml::table& table) {
  const string type = table["type"].value_or(string("none"));
  const string known = " type inflate center radius semi_axes lower upper normal offset of ";
  for (const auto& [name, value] : table) {
    const string key(name.str());
    if (known.find(" " + key + " ") == known.npos || (key == "inflate" && value.value_or(1.0) != 0.0))
      fail("a region with " + key + ", which this program cannot check");
  }
  if (type == "none") return [](const Intervals&) { return -at(-INFINITY); };
  if (type == "ball" || type == "ellipsoid") {  // sum ((x_i - center_i) / radius_i)^2 - 1
    const Numbers center = list(table, "center");
    const Numbers radii =
        type == "ball" ? Numbers(center.size(), scalar(table, "radius")) : list(table, "semi_axes");
    if (!(*std::min_element(radii.begin(), radii.end()) > 0.0)) fail("a radius that is not positive");
    return [=](const Intervals& x) {
      Interval sum = at(-1.0);
      for (size_t d = 0; d < x.size(); ++d) {
        const Interval u = (x[d] - at(center.at(d))) * positive_inverse(at(radii.at(d)));
        const double least = max(max(-u.upper, -u.minus_lower), 0.0);  // of |u|
        sum = sum + Interval{(u * u).upper, -least * least};
      }
      return sum;
    };
  }
  if (type == "box")
    return [lower = list(table, "lower"), upper = list(table, "upper")](const Intervals& x) {
      Interval most = at(-INFINITY);
      for (size_t d = 0; d < x.size(); ++d) {
        if (lower.at(d) > -INFINITY) most = maximum(most, at(lower[d]) - x[d]);
        if (upper.at(d) < INFINITY) most = maximum(most, x[d] - at(upper[d]));
      }
      return most;
    };
  if (type == "halfspace")
    return [normal = list(table, "normal"), offset = scalar(table, "offset")](const Intervals& x) {
      Interval sum = at(-offset);
      for (size_t d = 0; d < x.size(); ++d) add_multiple(normal.at(d), x[d], sum);
      return sum;
    };
  std::vector<Region> parts;
  if (const toml::array* of = table["of"].as_array())
    for (const toml::node& node : *of) parts.push_back(read_region(*node.as_table()));
  if (parts.empty() || (type != "union" && type != "intersection" && type != "complement"))
    fail("a region of type " + type + ", which this program cannot check");
  return [type, parts](const Intervals& x) {  // the least, the greatest, the negated level
    Interval level = parts[0](x);
    for (const Region& part : parts)
      level = type == "union" ? -maximum(-level, -part(x)) : maximum(level, part(x));
    return type == "complement" ? -level : level;
  };
}
// The conditions that boxes are asked for: their names in the file, and what they say.
constexpr const char* conditions[][2] = {{"lyapunov_decrease", "Vdot < 0 but at the goal"},
                                         {"initial", "B < 0 on the initial set"},
                                         {"unsafe", "B > 0 on the unsafe set"},
                                         {"containment", "B > 0 on the workspace's margin and boundary"},
                                         {"barrier_decrease", "Bdot < 0 where |B| <= the band"}};
// What is to be checked, as the file states it.
struct Claim {
  Network f, V, B;
  Box workspace, inner;  // normalised: X, and the part of it within which {B <= 0} must lie
  double level_band = 0.0;
  Region initial, unsafe;
  Numbers goal;  // [n] both regions stand in x = goal + scale z, z normalised
  double scale = 1.0;
  string text;                 // the file's own words for the problem
  std::vector<Numbers> cover;  // bytes for each of the conditions; none in a run file
};
string read_bytes(const string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}
string sha256(const string& bytes) {
  unsigned char digest[32];
  if (EVP_Digest(bytes.data(), bytes.size(), digest, nullptr, EVP_sha256(), nullptr) != 1) fail("no SHA-256");
  string text;
  for (int k = 0; k < 64; ++k) text += "0123456789abcdef"[digest[k / 2] >> (k % 2 == 0 ? 4 : 0) & 15];
  return text;
}
class File {
 public:
  explicit File(const string& path) {
    const string bytes = read_bytes(path), mark = "\ns2nnds-sha256 ";
    const size_t from = std::max<size_t>(bytes.size(), 80) - 80, end = bytes.find(mark, from);
    is_whole = end != bytes.npos;
    if (is_whole && bytes.substr(end) != mark + sha256(bytes.substr(0, end)) + "\n")
      fail("damaged bytes: their SHA-256 is not the one at their end");
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file_ < 0) fail("no HDF5 file; expected a run file or a proof");
  }
  ~File() { H5Fclose(file_); }
  bool holds(const string& item) const { return H5Lexists(file_, item.c_str(), H5P_DEFAULT) > 0; }
  string text(const string& group, const string& name) const {
    char* found = nullptr;
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    read(group, name, type, &found);
    return found != nullptr ? found : "";
  }
  double number(const string& group, const string& name) const {
    double found = NAN;
    read(group, name, H5T_NATIVE_DOUBLE, &found);
    if (!(found >= 0.0 && found <= 1e6)) fail("no " + group + " " + name + " within 1e6");
    return found;
  }
  Numbers array(const string& item) const {
    const hid_t set = H5Dopen2(file_, item.c_str(), H5P_DEFAULT), space = H5Dget_space(set);
    Numbers found(set < 0 ? 0 : static_cast<size_t>(H5Sget_simple_extent_npoints(space)));
    if (found.empty() || H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, found.data()) < 0)
      fail("no numbers " + item);
    return found;
  }
  bool is_whole = false;  // with the SHA-256 of its bytes behind them
 private:
  void read(const string& group, const string& name, hid_t type, void* value) const {
    const hid_t found = H5Aopen_by_name(file_, group.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    if (found < 0 || H5Aread(found, type, value) < 0) fail("no " + group + " " + name);
  }
  hid_t file_;
};
// `hashed` is what the weights' hash is taken of.
Network read_network(const File& file, const string& group, string& hashed) {
  const auto add = [&](const auto& word) { hashed.append(reinterpret_cast<const char*>(&word), 8); };
  const auto add_text = [&](const string& text) { add(text.size()), hashed += text; };
  Network network{file.text(group, "head"), file.number(group, "quadratic"), {}, {}};
  const auto count = static_cast<size_t>(file.number(group, "layers"));
  add_text(network.head == "zero_at_origin" ? "anchored" : network.head);
  add(network.quadratic);
  add(count);
  double growth = 1.0 + network.quadratic;
  for (size_t k = 0, inputs = static_cast<size_t>(file.number("/data", "dimension")); k < count; ++k) {
    const string index = std::to_string(k), activation = file.text(group, "activation_" + index);
    if (activation != "tanh" && activation != "identity")
      fail("the activation " + activation + ", which this program cannot check");
    const Numbers weight = file.array(group + "/weight_" + index);
    const size_t rows = inputs == 0 ? 0 : weight.size() / inputs;
    Layer layer{{}, {}, activation == "tanh"};
    if (file.holds(group + "/bias_" + index)) layer.bias = file.array(group + "/bias_" + index);
    if (rows == 0 || rows * inputs != weight.size() || (!layer.bias.empty() && layer.bias.size() != rows))
      fail("weights of " + group + " that do not fit together");
    for (auto from = weight.begin(); from != weight.end(); from += long(inputs))
      layer.weight.emplace_back(from, from + long(inputs));
    add_text(activation);
    for (const size_t size : {rows, inputs, layer.bias.size()}) add(size);
    double sum = 1.0;
    for (const Numbers* numbers : {&weight, &std::as_const(layer.bias)})
      for (const double number : *numbers) add(number), sum += fabs(number);
    growth *= sum;
    inputs = rows;
    network.layers.push_back(std::move(layer));
  }
  // Below this and with coordinates below 1e6 nothing overflows but the forms' rests, and those are only added to.
  if (!(growth <= 1e25) || count == 0) fail("no weights of " + group + ", or too large ones");
  return network;
}
// Throws one line on a file that is no such file or that this program cannot check.
Claim read_claim(const string& path) {
  const File file(path);
  Claim claim;
  string hashed;
  claim.f = read_network(file, "/networks/f", hashed);
  claim.V = read_network(file, "/networks/V", hashed);
  claim.B = read_network(file, "/networks/B", hashed);
  claim.text = file.text("/certificate", "scope");
  const toml::table scope = toml::parse(claim.text);
  if (scope["weights"].value_or(string()) != sha256(hashed))
    fail("other weights than those that the problem's text names");
  const auto &problem = need<toml::table>(scope, "problem"), &frame = need<toml::table>(scope, "frame");
  claim.workspace = {list(problem, "workspace_lower"), list(problem, "workspace_upper")};
  claim.inner = {list(problem, "contained_lower"), list(problem, "contained_upper")};
  claim.level_band = scalar(problem, "level_band");
  claim.initial = read_region(need<toml::table>(problem, "initial"));
  claim.unsafe = read_region(need<toml::table>(problem, "unsafe"));
  const size_t n = claim.workspace.lower.size();
  for (size_t d = 0; d < n; ++d) {
    const double low = claim.workspace.lower[d], high = claim.workspace.upper.at(d);
    if (!(low < 0.0 && high > 0.0 && high - low <= 1e6 && claim.inner.lower.at(d) >= low &&
          claim.inner.upper.at(d) <= high))
      fail("a workspace without the goal, or beyond 1e6, or not around the inner one");
  }
  const bool in_data = problem["frame"].value_or(string()) == "data";
  claim.goal = in_data ? list(frame, "goal") : Numbers(n);
  claim.scale = in_data ? scalar(frame, "position_scale") : 1.0;
  if (!(claim.level_band >= 0.0 && claim.scale > 0.0 && claim.scale < INFINITY && claim.goal.size() == n))
    fail("a band, a goal or a scale that is none");
  if (claim.f.inputs() != n || claim.f.outputs() != n || claim.B.outputs() != 1 || n > most_dimensions)
    fail("networks and a workspace of different dimensions, or of more than 4");
  if (file.holds("/cover")) {
    if (!file.is_whole) fail("no SHA-256 at the end of a proof");
    for (const auto& condition : conditions)
      claim.cover.push_back(file.array(string("/cover/") + condition[0]));
  }
  return claim;
}
// Whether the exported policy holds every bias, row or column of weights of f, V and B, those of a layer in their order: as
// doubles or floats in memory's form (ONNX, TorchScript, pt2) or as numbers in a text (C++ header; floats end with F).
bool carries_weights(const string& policy, const Claim& claim) {
  std::fesetround(FE_TONEAREST);  // as whoever rounded them to float
  const auto image = [](const Numbers& of, bool single) {
    const std::vector<float> rounded(of.begin(), of.end());
    const void* from = single ? static_cast<const void*>(rounded.data()) : of.data();
    return string(static_cast<const char*>(from), of.size() * (single ? sizeof(float) : sizeof(double)));
  };
  string bytes = read_bytes(policy);
  if (bytes.find('\0') == bytes.npos) {
    string found[2];  // doubles, floats
    char* end = nullptr;
    for (const char* from = bytes.c_str(); *from != '\0'; from = end > from ? end : from + 1) {
      const double number = std::strtod(from, &end);
      if (end > from) found[*end == 'F'] += image({number}, *end == 'F');
    }
    bytes = found[0] + found[1];
  }
  const auto holds = [&](const std::vector<Numbers>& lines, bool single) {
    size_t from = 0;
    for (const Numbers& line : lines) from = bytes.find(image(line, single), from);
    return from != bytes.npos;
  };
  const auto holds_network = [&](const Network& network, bool single) {
    for (const Layer& layer : network.layers) {
      std::vector<Numbers> columns(layer.weight.front().size());
      for (const Numbers& line : layer.weight)
        for (size_t k = 0; k < line.size(); ++k) columns[k].push_back(line[k]);
      if (!holds({layer.bias}, single) || !(holds(layer.weight, single) || holds(columns, single)))
        return false;
    }
    return true;
  };
  for (const Network* network : {&claim.f, &claim.V, &claim.B})
    if (!holds_network(*network, false) && !holds_network(*network, true)) return false;
  return true;
}
// Two boxes that share a face, so that no point is lost: halves along the widest side (the first of several), of `width`.
std::array<Box, 2> halves(const Box& box, double& width) {
  size_t axis = 0;
  const auto side = [&](size_t d) { return box.upper[d] - box.lower[d]; };
  for (size_t d = 1; d < box.lower.size(); ++d) axis = side(d) > side(axis) ? d : axis;
  width = side(axis);
  std::array<Box, 2> parts = {box, box};
  parts[0].upper[axis] = parts[1].lower[axis] = 0.5 * box.lower[axis] + 0.5 * box.upper[axis];
  return parts;
}
// Boxes that cover the workspace, for containment its faces too: those that the file's bisections end with, or it throws;
// without such, the workspace. What a bisection's end says is not used.
std::vector<Box> starting_boxes(const Claim& claim, size_t condition) {
  std::vector<Box> open = {claim.workspace}, ends;
  if (claim.cover.empty()) return open;
  for (size_t d = 0; condition == 3 && d < claim.workspace.lower.size(); ++d) {
    open.insert(open.begin(), 2, claim.workspace);
    open[0].lower[d] = open[0].upper[d];
    open[1].upper[d] = open[1].lower[d];
  }
  const Numbers& bytes = claim.cover[condition];
  size_t bit = 0;
  const auto next = [&] {
    if (bit == 8 * bytes.size()) fail(string("a cover with a hole for ") + conditions[condition][0]);
    const size_t place = bit++;
    return (static_cast<int>(bytes[place / 8]) >> (7 - place % 8) & 1) == 1;
  };
  std::fesetround(FE_TONEAREST);  // the same halves as whoever wrote the file
  double width = 0.0;
  for (Box box; !open.empty();) {
    box = std::move(open.back());
    open.pop_back();
    const std::array<Box, 2> parts = halves(box, width);
    if (next())
      open.insert(open.end(), {parts[1], parts[0]});
    else
      next(), ends.push_back(std::move(box));
  }
  round_up();
  while (bit % 8 != 0 || bit < 8 * bytes.size())
    if (bit % 8 == 0 || next()) fail("bits behind the end of a cover");
  return ends;
}
// Shows a condition on boxes that cover those of `open`, and counts them. Returns a box that stays open.
Box cover(std::vector<Box> open, const std::function<bool(const Box&)>& is_shown, long& boxes) {
  for (double width = 1.0; !open.empty(); ++boxes) {
    const Box box = std::move(open.back());
    open.pop_back();
    if (is_shown(box)) continue;
    for (const Box& part : halves(box, width)) open.push_back(part);
    if (width < 1e-9) return box;
  }
  return {};
}
// For |x|_inf <= half, f(x) = A x and N(x) - N(0) = P x with A, P in the Jacobians' enclosures, so that Vdot = x' M x with
// M = 2 (P' P + quadratic I) A. Negative definite if every pivot of -(M + M') is positive.
bool decreases_around_goal(const Network& f, const Network& V, double half) {
  const size_t n = f.inputs();
  const Box cube{Numbers(n, -half), Numbers(n, half)};
  const auto jacobian = [&](const Network& of) {
    std::vector<Intervals> j(of.outputs(), Intervals(n));
    for (size_t k = 0; k < n; ++k) {
      Tape tape(cube);
      const size_t direction = tape.size();
      for (size_t d = 0; d < n; ++d) tape.given(at(d == k ? 1.0 : 0.0));
      const size_t rate = apply(of, tape, direction).second;
      for (size_t i = 0; i < j.size(); ++i) j[i][k] = tape.rough_range(rate + i);
    }
    return j;
  };
  const auto add_product = [n](const Interval& a, const Intervals& b, Intervals& sum) {
    for (size_t k = 0; k < n; ++k) sum[k] = sum[k] + a * b[k];
  };
  const std::vector<Intervals> A = jacobian(f), P = jacobian(V);
  std::vector<Intervals> G(n, Intervals(n)), M = G, S = G;
  for (size_t i = 0; i < n; ++i) {
    G[i][i] = at(V.quadratic);
    for (const Intervals& row : P) add_product(row[i], row, G[i]);
    for (size_t l = 0; l < n; ++l) add_product(G[i][l], A[l], M[i]);
  }
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k < n; ++k) S[i][k] = -(M[i][k] + M[k][i]);
  for (size_t k = 0; k < n; ++k) {
    if (!(-S[k][k].minus_lower > 0.0)) return false;
    for (size_t i = k + 1; i < n; ++i) add_product(-(S[i][k] * positive_inverse(S[k][k])), S[k], S[i]);
  }
  return true;
}
// Whether the region has no point in the box.
bool misses(const Claim& claim, const Region& region, const Box& box) {
  Intervals x;
  for (size_t d = 0; d < box.lower.size(); ++d) {
    x.push_back(at(claim.goal[d]));
    add_multiple(claim.scale, {box.upper[d], -box.lower[d]}, x[d]);
  }
  return -region(x).minus_lower > 0.0;
}
bool run(const string& path, const std::vector<string>& policies) {
  round_up();
  Claim claim = read_claim(path);
  for (Network* network : {&claim.f, &claim.V, &claim.B}) find_offset(*network);
  const Network &f = claim.f, &V = claim.V, &B = claim.B;
  bool all = std::printf("%s\n%s\n", path.c_str(), claim.text.c_str()) > 0;
  const auto say = [&](const string& what, bool holds, long boxes = 0) {
    std::printf("%-50s %s", what.c_str(), holds ? "holds" : "NOT SHOWN");
    std::printf(boxes > 0 ? ", %ld boxes\n" : "\n", boxes);
    all = all && holds;
  };
  say("f(0) = 0, by its form", f.head == "zero_at_origin" && B.head == "plain");
  say("V(0) = 0 and V > 0 elsewhere, by its form", V.head == "squared_norm" && V.quadratic > 0.0);
  if (!all) return false;
  double cube = 0.08;  // Vdot < 0 for 0 < |x|_inf <= cube
  while (cube > 0.0 && !decreases_around_goal(f, V, cube)) cube = cube > 1e-7 ? 0.5 * cube : 0.0;
  const auto within = [](const Box& box, const Box& outer) {  // its interior
    for (size_t d = 0; d < box.lower.size(); ++d)
      if (!(box.upper[d] < outer.upper[d] && box.lower[d] > outer.lower[d])) return false;
    return true;
  };
  const Numbers origin(f.inputs());
  const Box around{Numbers(f.inputs(), -cube), Numbers(f.inputs(), cube)};
  const auto level = [&](const Box& box) { return value_range(B, box); };
  const auto rate = [&](const Network& of, const Box& box) { return rate_range(of, f, box).upper; };
  const double band = claim.level_band;
  const auto beyond_band = [&](Interval b) { return -b.minus_lower > band || -b.upper > band; };
  const auto negative = [](double x) {
    return x < 0.0 && x > -1e100;
  };  // nor NaN, nor what may have overflowed
  const std::function<bool(const Box&)> is_shown[] = {
      [&](const Box& box) { return within(box, around) || negative(rate(V, box)); },
      [&](const Box& box) { return misses(claim, claim.initial, box) || negative(level(box).upper); },
      [&](const Box& box) { return misses(claim, claim.unsafe, box) || negative(level(box).minus_lower); },
      [&](const Box& box) { return within(box, claim.inner) || negative(level(box).minus_lower); },
      [&](const Box& box) { return beyond_band(level(box)) || negative(rate(B, box)); }};
  std::array<long, std::size(conditions)> boxes{};
  std::array<std::future<Box>, std::size(conditions)> open;
  for (size_t k = 0; k < open.size(); ++k)
    open[k] = std::async(std::launch::async, [&, k] {
      return round_up(), cover(starting_boxes(claim, k), is_shown[k], boxes[k]);
    });
  for (size_t k = 0; k < open.size(); ++k) {
    const Box left = open[k].get();
    say(conditions[k][1], left.lower.empty(), boxes[k]);
    for (const double x : left.lower) std::printf("  open at %.9g\n", x);
  }
  say("B(0) <= 0", level({origin, origin}).upper <= 0.0);
  bool inside = true;  // the initial set has no point beyond any face of the workspace
  for (size_t d = 0; d < origin.size(); ++d) {
    Box above{Numbers(origin.size(), -1e300), Numbers(origin.size(), 1e300)}, below = above;
    above.lower[d] = std::nextafter(claim.workspace.upper[d], INFINITY);
    below.upper[d] = std::nextafter(claim.workspace.lower[d], -INFINITY);
    inside = inside && misses(claim, claim.initial, above) && misses(claim, claim.initial, below);
  }
  say("the initial set lies in the workspace", inside);
  if (all)
    std::printf(
        "Checked: every motion xdot = f(x) that starts in {B <= 0} stays in it for ever, never touches the "
        "unsafe set, and converges to the goal; the initial set lies in {B <= 0}.\n");
  for (const string& policy : policies) say("weights in " + policy, carries_weights(policy, claim));
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<string> arguments(argv + 1, argv + argc);
  if (arguments.empty() || arguments[0].starts_with("-")) {
    std::fprintf(stderr, "usage: s2nnds-check FILE [POLICY ...]\n");
    return 2;
  }
  H5dont_atexit();  // else it complains, as the program ends, of a damaged file that it could not close
  H5open();         // HDF5 1.14 crashes where it starts while numbers are not rounded to nearest
  try {
    return run(arguments[0], {arguments.begin() + 1, arguments.end()}) ? 0 : 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "s2nnds-check: %s: %s\n", arguments[0].c_str(), error.what());
    return 2;
  }
}
