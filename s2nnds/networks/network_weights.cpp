// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/networks/network_weights.h"

#include <openssl/evp.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "s2nnds/core/check.h"
#include "s2nnds/networks/evaluator.h"

namespace s2nnds {
namespace {

constexpr std::array<std::pair<Activation, std::string_view>, 6> activations = {
    {{Activation::identity, "identity"},
     {Activation::tanh, "tanh"},
     {Activation::elu, "elu"},
     {Activation::softplus, "softplus"},
     {Activation::silu, "silu"},
     {Activation::sine, "sine"}}};
constexpr std::array<std::pair<Head, std::string_view>, 4> heads = {
    {{Head::plain, "plain"},
     {Head::zero_at_origin, "zero_at_origin"},
     {Head::squared_norm, "squared_norm"},
     {Head::diffeomorphism, "diffeomorphism"}}};

template <typename Table>
std::string known(const Table& table) {
  std::string all;
  for (const auto& [value, name] : table) all += fmt::format("{}{}", all.empty() ? "" : ", ", name);
  return all;
}

// Feeds numbers to SHA-256 as little-endian 64-bit words, so that any program can recompute the hash.
class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new()) {
    check(context_ && EVP_DigestInit_ex(context_, EVP_sha256(), nullptr) == 1,
          "weight hash: SHA-256 is not available");
  }
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  ~Sha256() { EVP_MD_CTX_free(context_); }

  void add(std::string_view text) {
    add(static_cast<std::uint64_t>(text.size()));
    EVP_DigestUpdate(context_, text.data(), text.size());
  }
  void add(std::uint64_t word) {
    std::array<unsigned char, 8> bytes;
    for (int i = 0; i < 8; ++i) bytes[i] = static_cast<unsigned char>(word >> (8 * i));
    EVP_DigestUpdate(context_, bytes.data(), bytes.size());
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }

  std::string hex() {
    std::array<unsigned char, 32> digest;
    EVP_DigestFinal_ex(context_, digest.data(), nullptr);
    std::string text;
    for (unsigned char byte : digest) text += fmt::format("{:02x}", byte);
    return text;
  }

 private:
  EVP_MD_CTX* context_;
};

// What the hash says of a head. Part of the hash's definition: the same weights keep their hash when names change.
std::string_view hashed(Head head) { return head == Head::zero_at_origin ? "anchored" : to_string(head); }

void add(Sha256& hash, const NetworkWeights& stack) {
  hash.add(hashed(stack.head));
  hash.add(stack.quadratic);
  hash.add(static_cast<std::uint64_t>(stack.layers.size()));
  for (const Layer& layer : stack.layers) {
    hash.add(to_string(layer.activation));
    hash.add(static_cast<std::uint64_t>(layer.weight.rows()));
    hash.add(static_cast<std::uint64_t>(layer.weight.cols()));
    hash.add(static_cast<std::uint64_t>(layer.bias.size()));
    for (Eigen::Index i = 0; i < layer.weight.size(); ++i) hash.add(layer.weight.data()[i]);
    for (double b : layer.bias) hash.add(b);
  }
}

}  // namespace

std::string_view to_string(Activation activation) {
  for (const auto& [value, name] : activations) {
    if (value == activation) return name;
  }
  fail("activation: found the unknown value {}", static_cast<int>(activation));
}

Activation activation_from(std::string_view name) {
  for (const auto& [value, text] : activations) {
    if (text == name) return value;
  }
  fail("activation: found \"{}\", expected one of {}", name, known(activations));
}

std::vector<std::string> activation_names() {
  std::vector<std::string> names;
  for (const auto& [value, name] : activations) names.emplace_back(name);
  return names;
}

std::string_view to_string(Head head) {
  for (const auto& [value, name] : heads) {
    if (value == head) return name;
  }
  fail("head: found the unknown value {}", static_cast<int>(head));
}

Head head_from(std::string_view name) {
  for (const auto& [value, text] : heads) {
    if (text == name) return value;
  }
  fail("head: found \"{}\", expected one of {}", name, known(heads));
}

Eigen::Index NetworkWeights::input_dimension() const {
  return layers.empty() ? 0 : layers.front().weight.cols();
}

Eigen::Index NetworkWeights::output_dimension() const {
  if (is_sum_of_squares(head)) return 1;
  return layers.empty() ? 0 : layers.back().weight.rows();
}

std::size_t NetworkWeights::parameter_count() const {
  std::size_t count = 0;
  for (const Layer& layer : layers) count += layer.weight.size() + layer.bias.size();
  return count;
}

void NetworkWeights::check() const {
  s2nnds::check(!layers.empty(), "network: found no layers, expected at least one");
  s2nnds::check(quadratic >= 0.0 && std::isfinite(quadratic),
                "network: quadratic is {}, expected a number >= 0", quadratic);
  s2nnds::check(
      head != Head::diffeomorphism || (layers.back().weight.rows() == input_dimension() && quadratic == 0.0),
      "network: found a diffeomorphism of {} inputs and {} outputs with quadratic {}, expected as many "
      "outputs and 0",
      input_dimension(), layers.back().weight.rows(), quadratic);
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const Layer& layer = layers[k];
    s2nnds::check(layer.weight.size() > 0, "network: layer {} has an empty weight", k);
    s2nnds::check(k == 0 || layer.weight.cols() == layers[k - 1].weight.rows(),
                  "network: layer {} takes {} inputs, expected the {} outputs of the layer before", k,
                  layer.weight.cols(), k == 0 ? 0 : layers[k - 1].weight.rows());
    s2nnds::check(layer.bias.size() == 0 || layer.bias.size() == layer.weight.rows(),
                  "network: layer {} has a bias of {} numbers, expected {} or none", k, layer.bias.size(),
                  layer.weight.rows());
    s2nnds::check(layer.weight.allFinite() && layer.bias.allFinite(),
                  "network: layer {} holds a weight that is not a finite number", k);
  }
}

Points NetworkWeights::value(const Points& x) const { return Evaluator(*this).value(x); }

void NetworkWeights::value_and_derivative(const Points& x, const Points& direction, Points& value,
                                          Points& derivative) const {
  Evaluator(*this).value_and_derivative(x, direction, value, derivative);
}

void NetworkWeights::value_and_gradient(const Points& x, Vector& value, Points& gradient) const {
  Evaluator(*this).value_and_gradient(x, value, gradient);
}

std::string weight_hash(const Networks& networks) {
  Sha256 hash;
  add(hash, networks.f);
  add(hash, networks.V);
  add(hash, networks.B);
  if (networks.is_projected()) {
    hash.add("projected");
    hash.add(networks.decay);
  }
  return hash.hex();
}

}  // namespace s2nnds
