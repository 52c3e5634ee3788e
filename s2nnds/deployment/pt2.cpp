// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/pt2.h"

#include <nlohmann/json.hpp>

#include "s2nnds/core/check.h"
#include "s2nnds/core/child_process.h"
#include "s2nnds/core/json_text.h"
#include "s2nnds/core/python_module.h"
#include "s2nnds/deployment/pt2_writer.h"

namespace s2nnds {
namespace {

using nlohmann::json;

json numbers(const Vector& values) { return std::vector<double>(values.begin(), values.end()); }

json rows(const Points& values) {
  json result = json::array();
  for (Eigen::Index i = 0; i < values.rows(); ++i) result.push_back(numbers(values.row(i)));
  return result;
}

json describe(const NetworkWeights& network) {
  json layers = json::array();
  for (const Layer& layer : network.layers) {
    layers.push_back({{"weight", rows(layer.weight)},
                      {"bias", layer.bias.size() > 0 ? numbers(layer.bias) : json()},
                      {"activation", to_string(layer.activation)}});
  }
  const bool subtracts = network.head != Head::plain;
  return {{"layers", layers},
          {"head", to_string(network.head)},
          {"quadratic", network.quadratic},
          {"origin", subtracts ? numbers(layers_at_origin(network).row(0)) : json()}};
}

// What pt2_writer.py reads.
std::string description(const Policy& policy) {
  json info;
  policy.info.visit([&](const char* name, const auto& value, const char*) { info[name] = value; });
  const NetworkWeights &f = policy.networks.f, &V = policy.networks.V, &B = policy.networks.B;
  const json networks = {{"f", describe(f)}, {"V", describe(V)}, {"B", describe(B)}};
  return json_text(json{{"info", info}, {"networks", networks}});
}

// What a failed program said last.
std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of("\r\n ");
  if (end == std::string::npos) return "";
  const std::size_t begin = text.find_last_of("\r\n", end) + 1;  // npos + 1 = 0
  return text.substr(begin, end + 1 - begin);
}

[[noreturn]] void refuse(const std::string& reason) {
  fail("pt2: {} (S2NNDS_PYTHON names another Python)", reason);
}

ChildResult run_writer(const std::string& python, const std::string& input) {
  try {
    return run_child({python, "-c", pt2_writer_source}, input);
  } catch (const Error& e) {
    refuse(e.what());
  }
}

}  // namespace

std::string pt2_program(const Policy& policy) {
  check_plain_motion(policy, "pt2");
  const std::string python = python_program();
  const ChildResult writer = run_writer(python, description(policy));
  if (writer.exit_code != 0) {
    const std::string reason = last_line(writer.errors);
    refuse(python + ": " +
           (reason.empty() ? fmt::format("ended with exit code {}", writer.exit_code) : reason));
  }
  if (writer.output.empty()) refuse(python + ": found no output, expected a policy");
  return writer.output;
}

}  // namespace s2nnds
