// SPDX-License-Identifier: BSD-3-Clause
// s2nnds-check FILE [POLICY ...]: checks a run's or a written proof's certificate with no code of what made it.
#include <arb.h>
#include <arb_mat.h>
#include <hdf5.h>
#include <openssl/evp.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {
using std::fabs, std::max, std::min, std::size_t, std::string;
using Numbers = std::vector<double>;
[[noreturn]] void fail(const string& found) { throw std::runtime_error("found " + found); }
constexpr slong bits = 53;
// All bounds are made by Arb: an operation's ball holds the result of every number in its operands' balls.
class Ball {
 public:
  Ball(double x = 0.0) { arb_init(ball), arb_set_d(ball, x); }  // exact
  Ball(const Ball& other) { arb_init(ball), arb_set(ball, other.ball); }
  Ball(Ball&& other) noexcept { arb_init(ball), arb_swap(ball, other.ball); }
  Ball& operator=(Ball other) noexcept { return arb_swap(ball, other.ball), *this; }
  ~Ball() { arb_clear(ball); }
  bool is_positive() const { return arb_is_positive(ball) != 0; }  // all of it; false if it is unknown
  bool is_negative() const { return arb_is_negative(ball) != 0; }
  arb_t ball;
};
using Balls = std::vector<Ball>;
static_assert(sizeof(Ball) == sizeof(arb_struct));  // arb_dot goes over many
template <auto operation>
Ball made_by(Ball a, const Ball& b) {
  return operation(a.ball, a.ball, b.ball, bits), a;
}
Ball operator+(const Ball& a, const Ball& b) { return made_by<arb_add>(a, b); }
Ball operator-(const Ball& a, const Ball& b) { return made_by<arb_sub>(a, b); }
Ball operator*(const Ball& a, const Ball& b) { return made_by<arb_mul>(a, b); }
Ball operator/(const Ball& a, const Ball& b) { return made_by<arb_div>(a, b); }
Ball operator-(Ball a) { return arb_neg(a.ball, a.ball), a; }
Ball hull(const Ball& a, const Ball& b) { return made_by<arb_union>(a, b); }
Ball least(const Ball& a, const Ball& b) { return made_by<arb_min>(a, b); }
Ball greatest(const Ball& a, const Ball& b) { return made_by<arb_max>(a, b); }
bool is_at_most(const Ball& a, const Ball& b) { return arb_le(a.ball, b.ball) != 0; }
Ball tanh(Ball a) { return arb_tanh(a.ball, a.ball, bits), a; }
const Ball zero, one(1.0), two(2.0), half(0.5);
// start + sum_k a_k b_k over `count` balls, of b every `stride`-th.
Ball dot(const Ball& start, const Ball* a, const Ball* b, size_t count, size_t stride = 1) {
  Ball sum;
  return arb_dot(sum.ball, start.ball, 0, a->ball, 1, b->ball, slong(stride), slong(count), bits), sum;
}
struct Box {
  Numbers lower, upper;  // [n]
};
// As the file has it: N(x), N(x) - N(0) or |N(x) - N(0)|^2 + quadratic |x|^2.
struct Layer {
  std::vector<Numbers> weight;  // [out][in]
  Numbers bias;                 // [out] or empty
  bool tanh = false;            // else the identity
  std::vector<Balls> balls;     // the weights again
};
struct Network {
  string head;
  double quadratic = 0.0;
  std::vector<Layer> layers;
  Balls offset;  // N(0), or none for the head `plain`
  size_t inputs() const { return layers.front().weight.front().size(); }
  size_t outputs() const { return layers.back().weight.size(); }
};
struct Place {  // a box X by its center c and X - c
  explicit Place(const Box& box) {
    for (size_t d = 0; d < box.lower.size(); ++d) {
      center.emplace_back(0.5 * box.lower[d] + 0.5 * box.upper[d]);
      step.push_back(hull(Ball(box.lower[d]) - center[d], Ball(box.upper[d]) - center[d]));
    }
  }
  size_t n() const { return center.size(); }
  Balls center, step;  // [n]
};
// Functions on a box X with center c. By the mean value theorem g(x) = g(c) + grad g(y) . (x - c) with y between x and c, so
// g(X) lies in g(c) + grad g(X) . (X - c). Of order 1, a function has its value at c and its gradient over X; of order 2 its value
// and gradient at c and its hessian over X, whence its gradient over X by the same theorem.
class Functions {
 public:
  Functions(const Place& place, size_t order, size_t count)
      : place_(&place), order_(order), balls_(count * columns()) {}
  const Place& place() const { return *place_; }
  size_t columns() const { return order_ == 1 ? 1 + n() : 1 + n() + n() * n(); }
  Ball* at(size_t k) { return &balls_[k * columns()]; }
  const Ball* at(size_t k) const { return &balls_[k * columns()]; }
  const Ball& value(size_t k) const { return at(k)[0]; }      // at c
  const Ball* gradient(size_t k) const { return at(k) + 1; }  // at c, or over X for order 1
  const Ball* hessian(size_t k, size_t i = 0) const { return at(k) + 1 + n() + i * n(); }  // its row i
  Balls gradient_over(size_t k, const Ball& part = one) const {
    Balls g(gradient(k), gradient(k) + n());
    for (size_t i = 0; order_ == 2 && i < n(); ++i) g[i] = g[i] + part * along_step(hessian(k, i));
    return g;
  }
  // g(X) - g(c). On the way from c to x, grad g lies on average in grad g(c) + hess g(X) (X - c) / 2.
  Ball change(size_t k) const { return along_step(gradient_over(k, half).data()); }
  Ball value_over(size_t k) const { return value(k) + change(k); }
  Ball along_step(const Ball* slope) const { return dot(zero, slope, place_->step.data(), n()); }
  // W x + b
  Functions after(const Layer& layer) const {
    const size_t rows = layer.weight.size(), inputs = layer.weight.front().size();
    Functions y(*place_, order_, rows);
    for (size_t k = 0; k < rows; ++k)
      for (size_t c = 0; c < columns(); ++c) {
        const size_t i = c <= n() ? 0 : (c - 1) / n() - 1, j = c <= n() ? 0 : (c - 1) % n();
        y.at(k)[c] = j < i ? y.hessian(k, j)[i]
                           : dot(c == 0 && !layer.bias.empty() ? Ball(layer.bias[k]) : zero,
                                 layer.balls[k].data(), at(0) + c, inputs, columns());
      }
    return y;
  }
  // z_k becomes tanh(z_k), by the chain rule. With t = tanh(z), tanh' = 1 - t^2 and tanh'' = -2 t (1 - t^2).
  void apply_tanh(size_t k) {
    Ball* z = at(k);
    const Ball step = change(k), t = tanh(z[0]), over = tanh(z[0] + step);
    Ball first = one - over * over;
    if (order_ == 1) {
      for (size_t i = 1; i <= n(); ++i) z[i] = first * z[i];
    } else {
      const Balls gradient = gradient_over(k);
      const Ball at_center = one - t * t, mean = at_center - two * over * first * step;
      if (mag_cmp(arb_radref(mean.ball), arb_radref(first.ball)) < 0) first = mean;
      const Ball second = -(two * over * first);
      for (size_t i = 0; i < n(); ++i) {
        const Ball along = second * gradient[i];
        for (size_t j = 0; j < n(); ++j) {
          Ball& h = z[1 + n() + i * n() + j];
          h = along * gradient[j] + first * h;
        }
        z[1 + i] = at_center * z[1 + i];
      }
    }
    z[0] = t;
  }

 private:
  size_t n() const { return place_->n(); }
  const Place* place_;
  size_t order_;
  Balls balls_;
};
// N or N - N(0) on the box.
Functions apply(const Network& network, const Place& place, size_t order) {
  Functions x(place, order, place.n());
  for (size_t d = 0; d < place.n(); ++d) x.at(d)[0] = place.center[d], x.at(d)[1 + d] = one;
  for (const Layer& layer : network.layers) {
    x = x.after(layer);
    for (size_t k = 0; layer.tanh && k < layer.weight.size(); ++k) x.apply_tanh(k);
  }
  for (size_t k = 0; k < network.offset.size(); ++k) x.at(k)[0] = x.value(k) - network.offset[k];
  return x;
}
// V = |u|^2 + q |x|^2.
Functions squared_norm(const Network& network, const Place& place) {
  const size_t n = place.n();
  const Functions u = apply(network, place, 2);
  Functions v(place, 2, 1);
  Ball *gradient = v.at(0) + 1, *hessian = gradient + n;  // the value is not needed
  const Ball twice(2.0 * network.quadratic);
  for (size_t d = 0; d < n; ++d) gradient[d] = twice * place.center[d], hessian[d * n + d] = twice;
  for (size_t k = 0; k < network.outputs(); ++k) {
    const Ball value = two * u.value(k), over = two * u.value_over(k);
    const Balls slope = u.gradient_over(k);
    for (size_t i = 0; i < n; ++i) {
      gradient[i] = gradient[i] + value * u.gradient(k)[i];
      for (size_t j = 0; j < n; ++j)
        hessian[i * n + j] = hessian[i * n + j] + two * slope[i] * slope[j] + over * u.hessian(k, i)[j];
    }
  }
  return v;
}
// grad w . f on the box, w of order 2: its gradient there is hess w f + (grad f)' grad w.
Ball rate_range(const Functions& w, const Network& f) {
  const size_t n = f.inputs();
  const Functions field = apply(f, w.place(), 1);
  const Balls gradient = w.gradient_over(0);
  Ball rate;
  Balls slope(n);
  for (size_t i = 0; i < n; ++i) {
    const Ball over = field.value_over(i);
    rate = rate + w.gradient(0)[i] * field.value(i);
    for (size_t j = 0; j < n; ++j)
      slope[j] = slope[j] + w.hessian(0, i)[j] * over + gradient[i] * field.gradient(i)[j];
  }
  return rate + w.along_step(slope.data());
}
using Level = std::function<Ball(const Balls&)>;  // encloses a function on a box [n]
// Reads a level made of numbers, x, y, z, + - * / ** ^, max, min and parentheses.
struct Expression {
  string rest;                 // still to be read
  bool is_even_power = false;  // what was read last, so that it is >= 0
  bool take(const string& word) { return rest.starts_with(word) && (rest.erase(0, word.size()), true); }
  template <auto operation>
  Level join(const Level& a, const Level& b) {
    is_even_power = false;
    return [a, b](const Balls& x) { return made_by<operation>(a(x), b(x)); };
  }
  Level chain(bool sums) {  // of terms, or of a term's factors
    const auto next = [&] { return sums ? chain(false) : factor(); };
    for (Level a = next();;)
      if (take(sums ? "+" : "*"))
        a = sums ? join<arb_add>(a, next()) : join<arb_mul>(a, next());
      else if (take(sums ? "-" : "/"))
        a = sums ? join<arb_sub>(a, next()) : join<arb_div>(a, next());
      else
        return a;
  }
  Level factor() {
    if (take("-")) return join<arb_sub>([](const Balls&) { return zero; }, factor());
    const Level a = atom();
    if (!take("**") && !take("^")) return a;
    const bool was_even = is_even_power;
    const Ball e = factor()({});  // throws where it is no constant
    is_even_power = was_even || arb_is_int((half * e).ball) != 0;
    if (!is_even_power || !e.is_positive()) fail("a power that this program cannot check");
    return [a, e](const Balls& x) {  // |a|^e
      Ball from, to;
      arb_get_abs_lbound_arf(arb_midref(from.ball), a(x).ball, bits);
      arb_get_abs_ubound_arf(arb_midref(to.ball), a(x).ball, bits);
      const auto power = [&](const Ball& b) { return arb_is_zero(b.ball) ? zero : made_by<arb_pow>(b, e); };
      return hull(power(from), power(to));
    };
  }
  Level atom() {
    const bool is_most = take("max("), is_list = is_most || take("min(");
    if (is_list || take("(")) {
      Level a = chain(true);
      while (is_list && take(","))
        a = is_most ? join<arb_max>(a, chain(true)) : join<arb_min>(a, chain(true));
      return take(")") ? a : (fail("no ) at " + rest), a);
    }
    is_even_power = false;
    for (const size_t axis : {0, 1, 2})
      if (take(string(1, "xyz"[axis]))) return [axis](const Balls& x) { return x.at(axis); };
    size_t length = 0;
    const Ball number(std::stod(rest, &length));  // throws where it is none
    rest.erase(0, length);
    return [number](const Balls&) { return number; };
  }
};
struct Region {  // a set {level <= 0} and bounds of it [n]
  Level level;
  Balls lower, upper;
};
template <typename T>
const T& need(const toml::table& table, const char* key) {
  const T* found = table[key].as<T>();
  return found != nullptr ? *found : (fail(string("no ") + key + " as expected"), *found);
}
Numbers list(const toml::table& table, const char* key) {
  Numbers found;
  for (const toml::node& node : need<toml::array>(table, key)) found.push_back(node.value<double>().value());
  return found;
}
double scalar(const toml::table& table, const char* key) {
  return table[key].is_number() ? *table[key].value<double>() : (fail(string("no number ") + key), NAN);
}
// From its TOML table. Throws on what this program does not know.
Region read_region(const toml::table& table, size_t n) {
  const string type = table["type"].value_or(string("none"));
  const string known = " type inflate center radius semi_axes lower upper normal offset of level from to ";
  for (const auto& [name, value] : table) {
    const string key(name.str());
    if (known.find(" " + key + " ") == known.npos || (key == "inflate" && value.value_or(1.0) != 0.0))
      fail("a region with " + key + ", which this program cannot check");
  }
  const auto numbers = [&](const char* key) {
    const Numbers found = list(table, key);
    return found.size() == n ? found : (fail(string("no n numbers ") + key), found);
  };
  Region region{{}, Balls(n, -INFINITY), Balls(n, INFINITY)};
  if (type == "none") {
    region = {[](const Balls&) { return Ball(1.0); }, region.upper, region.lower};
  } else if (type == "ball" || type == "ellipsoid") {  // sum ((x_i - center_i) / radius_i)^2 - 1
    const Numbers center = numbers("center"),
                  radii = type == "ball" ? Numbers(n, scalar(table, "radius")) : numbers("semi_axes");
    if (!(*std::min_element(radii.begin(), radii.end()) > 0.0)) fail("a radius that is not positive");
    for (size_t d = 0; d < n; ++d)
      region.lower[d] = Ball(center[d]) - radii[d], region.upper[d] = Ball(center[d]) + radii[d];
    region.level = [=](const Balls& x) {
      Balls u;
      for (size_t d = 0; d < n; ++d) u.push_back((x[d] - center[d]) / radii[d]);
      return dot(Ball(-1.0), u.data(), u.data(), n);
    };
  } else if (type == "box") {
    const Numbers lower = numbers("lower"), upper = numbers("upper");
    region.lower.assign(lower.begin(), lower.end());
    region.upper.assign(upper.begin(), upper.end());
    region.level = [=](const Balls& x) {
      Ball most(-1e300);
      for (size_t d = 0; d < n; ++d) most = greatest(most, greatest(Ball(lower[d]) - x[d], x[d] - upper[d]));
      return most;
    };
  } else if (type == "expression") {
    Expression whole{table["level"].value_or(string())};
    std::erase(whole.rest, ' ');
    region.level = whole.chain(true);
    if (!whole.rest.empty()) fail("no expression at " + whole.rest);
  } else if (type == "extrusion") {  // of a region of n - 1 coordinates, to from <= x_n <= to
    const toml::table* of = table["of"][0].as_table();
    if (n < 2 || of == nullptr || table["of"][1]) fail("an extrusion of something else than one region");
    region = read_region(*of, n - 1);
    region.lower.emplace_back(scalar(table, "from")), region.upper.emplace_back(scalar(table, "to"));
    region.level = [base = region.level, from = region.lower[n - 1],
                    to = region.upper[n - 1]](const Balls& x) {
      return greatest(base({x.begin(), x.end() - 1}), greatest(from - x.back(), x.back() - to));
    };
  } else if (type == "halfspace") {
    const Numbers normal = numbers("normal");
    region.level = [weights = Balls(normal.begin(), normal.end()), offset = Ball(-scalar(table, "offset"))](
                       const Balls& x) { return dot(offset, weights.data(), x.data(), x.size()); };
  } else {
    std::vector<Region> parts;
    if (const toml::array* of = table["of"].as_array())
      for (const toml::node& node : *of) parts.push_back(read_region(*node.as_table(), n));
    if (parts.empty() || (type != "union" && type != "intersection" && type != "complement"))
      fail("a region of type " + type + ", which this program cannot check");
    const bool joined = type == "union";
    if (type != "complement") region = parts[0];
    for (size_t k = n; joined && k < n * parts.size(); ++k) {
      region.lower[k % n] = least(region.lower[k % n], parts[k / n].lower[k % n]);
      region.upper[k % n] = greatest(region.upper[k % n], parts[k / n].upper[k % n]);
    }
    region.level = [type, parts, joined](const Balls& x) {  // the least, the greatest, the negated level
      Ball level = parts[0].level(x);
      for (const Region& part : parts) level = (joined ? least : greatest)(level, part.level(x));
      return type == "complement" ? -level : level;
    };
  }
  return region;
}
// The conditions that boxes are asked for: their names in the file, and what they say.
constexpr const char* conditions[][2] = {{"lyapunov_decrease", "Vdot < 0 but at the goal"},
                                         {"initial", "B < 0 on the initial set"},
                                         {"unsafe", "B > 0 on the unsafe set"},
                                         {"containment", "B > 0 on the workspace's margin and boundary"},
                                         {"barrier_decrease", "Bdot < 0 where |B| <= the band"}};
struct Claim {  // what is to be checked, as the file states it
  Network f, V, B;
  Box workspace, inner;  // normalised: X, and the part of it within which {B <= 0} must lie
  double level_band = 0.0;
  Region initial, unsafe;
  Numbers goal;  // [n] both regions stand in x = goal + scale z, z normalised
  double scale = 1.0;
  string text, unchecked;      // the file's own words for the problem, and which of them are not looked at
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
  if (network.head == "diffeomorphism") fail("V as a diffeomorphism, which this program cannot check");
  const auto count = static_cast<size_t>(file.number(group, "layers"));
  add_text(network.head == "zero_at_origin" ? "anchored" : network.head);
  add(network.quadratic);
  add(count);
  for (size_t k = 0, inputs = static_cast<size_t>(file.number("/data", "dimension")); k < count; ++k) {
    const string index = std::to_string(k), activation = file.text(group, "activation_" + index);
    if (activation != "tanh" && activation != "identity")
      fail("the activation " + activation + ", which this program cannot check");
    const Numbers weight = file.array(group + "/weight_" + index);
    const size_t rows = inputs == 0 ? 0 : weight.size() / inputs;
    Layer layer{{}, {}, activation == "tanh", {}};
    if (file.holds(group + "/bias_" + index)) layer.bias = file.array(group + "/bias_" + index);
    if (rows == 0 || rows * inputs != weight.size() || (!layer.bias.empty() && layer.bias.size() != rows))
      fail("weights of " + group + " that do not fit together");
    for (auto from = weight.begin(); from != weight.end(); from += long(inputs))
      layer.weight.emplace_back(from, from + long(inputs)),
          layer.balls.emplace_back(from, from + long(inputs));
    add_text(activation);
    for (const size_t size : {rows, inputs, layer.bias.size()}) add(size);
    for (const Numbers* numbers : {&weight, &std::as_const(layer.bias)})
      for (const double number : *numbers) add(number);
    inputs = rows;
    network.layers.push_back(std::move(layer));
  }
  if (count == 0) fail("no weights of " + group);
  const Place origin({Numbers(network.inputs()), Numbers(network.inputs())});
  const Functions at_origin = apply(network, origin, 1);
  for (size_t k = 0; network.head != "plain" && k < network.outputs(); ++k)
    network.offset.push_back(at_origin.value(k));
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
  const size_t n = claim.workspace.lower.size();
  claim.initial = read_region(need<toml::table>(problem, "initial"), n);
  claim.unsafe = read_region(need<toml::table>(problem, "unsafe"), n);
  for (const char* part : {"execution", "orientation"})
    if (scope.contains(part)) claim.unchecked += string(" [") + part + "]";
  for (size_t d = 0; d < n; ++d) {
    const double low = claim.workspace.lower[d], high = claim.workspace.upper.at(d);
    if (!(low < 0.0 && high > 0.0 && high - low < INFINITY)) fail("a workspace without goal or bounds");
    if (!(claim.inner.lower.at(d) >= low && claim.inner.upper.at(d) <= high))
      fail("too large an inner workspace");
  }
  const bool in_data = problem["frame"].value_or(string()) == "data";
  claim.goal = in_data ? list(frame, "goal") : Numbers(n);
  claim.scale = in_data ? scalar(frame, "position_scale") : 1.0;
  if (!(claim.level_band >= 0.0 && claim.scale > 0.0 && claim.scale < INFINITY && claim.goal.size() == n))
    fail("a band, a goal or a scale that is none");
  for (const size_t size : {claim.f.inputs(), claim.f.outputs(), claim.V.inputs(), claim.B.inputs()})
    if (size != n || claim.B.outputs() != 1) fail("networks and a workspace of different dimensions");
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
  const auto is_held = [&](const Network& network, bool single) {
    return std::all_of(network.layers.begin(), network.layers.end(), [&](const Layer& layer) {
      std::vector<Numbers> columns(layer.weight[0].size());
      for (const Numbers& line : layer.weight)
        for (size_t k = 0; k < line.size(); ++k) columns[k].push_back(line[k]);
      return holds({layer.bias}, single) && (holds(layer.weight, single) || holds(columns, single));
    });
  };
  const auto carried = [&](const Network& network) {
    return is_held(network, false) || is_held(network, true);
  };
  return carried(claim.f) && carried(claim.V) && carried(claim.B);
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
// Boxes that cover the workspace, for containment its faces too: the ends of the file's bisections if it has any.
std::vector<Box> starting_boxes(const Claim& claim, size_t condition) {
  std::vector<Box> open = {claim.workspace}, ends;
  if (claim.cover.empty()) return open;
  for (size_t d = 0; condition == 3 && d < claim.workspace.lower.size(); ++d) {
    open.insert(open.begin(), 2, claim.workspace);
    open[0].lower[d] = open[0].upper[d], open[1].upper[d] = open[1].lower[d];
  }
  const Numbers& bytes = claim.cover[condition];
  size_t bit = 0;
  const auto next = [&] {
    if (bit == 8 * bytes.size()) fail(string("a cover with a hole for ") + conditions[condition][0]);
    const size_t place = bit++;
    return (static_cast<int>(bytes[place / 8]) >> (7 - place % 8) & 1) == 1;
  };
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
  while (bit % 8 != 0 || bit < 8 * bytes.size())
    if (bit % 8 == 0 || next()) fail("bits behind the end of a cover");
  return ends;
}
// Shows on boxes that cover those of `open` that a quantity is negative, and counts them. Returns a box that stays open.
Box cover(std::vector<Box> open, const std::function<Ball(const Box&)>& enclose, long& boxes) {
  for (double width = 1.0; !open.empty(); ++boxes) {
    const Box box = open.back();
    open.pop_back();
    const Ball found = enclose(box);
    if (found.is_negative()) continue;
    const size_t last = open.size();
    open.push_back(box);
    // Where the radius is large, one bisection would not do: one for each axis.
    const bool large =
        mag_get_d(arb_radref(found.ball)) > -2.0 * arf_get_d(arb_midref(found.ball), ARF_RND_NEAR);
    for (size_t k = large ? box.lower.size() : 1; k > 0; --k)
      for (size_t i = open.size(); i-- > last;) {
        const std::array<Box, 2> parts = halves(open[i], width);
        open[i] = parts[0], open.push_back(parts[1]);
      }
    if (width < 1e-9) return box;
  }
  return {};
}
struct Matrix {  // of balls
  Matrix(size_t rows, size_t columns) { arb_mat_init(all, slong(rows), slong(columns)); }
  ~Matrix() { arb_mat_clear(all); }
  arb_mat_t all;
};
// For |x|_inf <= edge, f(x) = A x and N(x) - N(0) = P x with A, P in the Jacobians' enclosures, so that Vdot = x' M x with
// M = 2 (P' P + quadratic I) A. Negative definite if -(M + M') has a Cholesky factor.
bool decreases_around_goal(const Network& f, const Network& V, double edge) {
  const size_t n = f.inputs();
  const Place cube({Numbers(n, -edge), Numbers(n, edge)});
  const auto set_jacobian = [&](const Network& of, Matrix& j) {
    const Functions u = apply(of, cube, 2);
    for (size_t i = 0; i < of.outputs(); ++i) {
      const Balls gradient = u.gradient_over(i);
      for (size_t k = 0; k < n; ++k) arb_set(arb_mat_entry(j.all, i, k), gradient[k].ball);
    }
  };
  Matrix A(n, n), P(V.outputs(), n), transposed(n, V.outputs()), G(n, n), M(n, n), S(n, n), I(n, n);
  set_jacobian(f, A);
  set_jacobian(V, P);
  arb_mat_transpose(transposed.all, P.all);
  arb_mat_mul(G.all, transposed.all, P.all, bits);
  arb_mat_one(I.all);
  arb_mat_scalar_addmul_arb(G.all, I.all, Ball(V.quadratic).ball, bits);
  arb_mat_mul(M.all, G.all, A.all, bits);
  arb_mat_transpose(S.all, M.all);
  arb_mat_add(S.all, S.all, M.all, bits);
  arb_mat_neg(S.all, S.all);
  return arb_mat_cho(M.all, S.all, bits) != 0;  // of all matrices in S
}
// x = goal + scale z, in the regions' frame.
Ball placed(const Claim& claim, size_t d, const Ball& z) {
  return Ball(claim.goal[d]) + Ball(claim.scale) * z;
}
// Whether the region has no point in the box.
bool misses(const Claim& claim, const Region& region, const Box& box) {
  Balls x;
  for (size_t d = 0; d < box.lower.size(); ++d)
    x.push_back(placed(claim, d, hull(box.lower[d], box.upper[d])));
  return region.level(x).is_positive();
}
bool run(const string& path, const std::vector<string>& policies) {
  const Claim claim = read_claim(path);
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
  const Ball band(claim.level_band);
  const auto level = [&](const Box& box) { return apply(B, Place(box), 2).value_over(0); };
  const Ball shown(-1.0);
  const std::function<Ball(const Box&)> negative[] = {
      [&](const Box& x) { return within(x, around) ? shown : rate_range(squared_norm(V, Place(x)), f); },
      [&](const Box& box) { return misses(claim, claim.initial, box) ? shown : level(box); },
      [&](const Box& box) { return misses(claim, claim.unsafe, box) ? shown : -level(box); },
      [&](const Box& box) { return within(box, claim.inner) ? shown : -level(box); },
      [&](const Box& box) {
        const Place place(box);
        const Functions u = apply(B, place, 2);
        const Ball b = u.value_over(0);
        return (b - band).is_positive() || (b + band).is_negative() ? shown : rate_range(u, f);
      }};
  std::array<long, std::size(conditions)> boxes{};
  std::array<std::future<Box>, std::size(conditions)> open;
  const auto task = [&](size_t k) { return cover(starting_boxes(claim, k), negative[k], boxes[k]); };
  for (size_t k = 0; k < open.size(); ++k) open[k] = std::async(std::launch::async, task, k);
  for (size_t k = 0; k < open.size(); ++k) {
    const Box left = open[k].get();
    say(conditions[k][1], left.lower.empty(), boxes[k]);
    for (const double x : left.lower) std::printf("  open at %.9g\n", x);
  }
  say("B(0) <= 0", arb_is_nonpositive(level({origin, origin}).ball) != 0);
  bool inside = true;
  for (size_t d = 0; d < origin.size(); ++d)
    inside = inside && is_at_most(placed(claim, d, claim.workspace.lower[d]), claim.initial.lower[d]) &&
             is_at_most(claim.initial.upper[d], placed(claim, d, claim.workspace.upper[d]));
  say("the initial set lies in the workspace", inside);
  if (all)
    std::puts(
        "Checked: every motion xdot = f(x) that starts in {B <= 0} stays in it for ever, never touches the "
        "unsafe set, and converges to the goal; the initial set lies in {B <= 0}.");
  if (!claim.unchecked.empty())
    std::printf("Not checked:%s; this is of xdot = f(x).\n", claim.unchecked.c_str());
  for (const string& policy : policies) say("weights in " + policy, carries_weights(policy, claim));
  return all;
}
}  // namespace
int main(int argc, char** argv) {
  const std::vector<string> arguments(argv + 1, argv + argc);
  if (arguments.empty() || arguments[0].starts_with("-"))
    return std::fputs("usage: s2nnds-check FILE [POLICY ...]\n", stderr), 2;
  H5dont_atexit();  // else it complains, as the program ends, of a damaged file that it could not close
  try {
    return run(arguments[0], {arguments.begin() + 1, arguments.end()}) ? 0 : 3;
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "s2nnds-check: %s: %s\n", arguments[0].c_str(), error.what()), 2;
  }
}
