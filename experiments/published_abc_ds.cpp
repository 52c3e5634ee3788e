// SPDX-License-Identifier: BSD-3-Clause
#include "published_abc_ds.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "s2nnds/core/check.h"
#include "s2nnds/verification/polynomial_function.h"
#include "s2nnds/verification/prover.h"

namespace s2nnds::experiment {
namespace {

// The solver leaves linear terms of V below 1e-15 in the files at hand, by which V < 0 somewhere arbitrarily
// near the goal. They are noise, and are dropped here: what is judged is the V that was meant.
Polynomial without_linear_noise(const Polynomial& V) {
  Vector coefficients = V.coefficients();
  for (Eigen::Index t = 0; t < V.terms(); ++t) {
    if (V.exponents().row(t).sum() <= 1 && std::abs(coefficients[t]) < 1e-12) coefficients[t] = 0.0;
  }
  return {coefficients, V.exponents()};
}

std::vector<Polynomial> polynomials(const nlohmann::json& text) {
  std::vector<Polynomial> all;
  if (!text.is_array()) return {Polynomial::from_text(text.get<std::string>(), 2)};
  for (const auto& one : text) all.push_back(Polynomial::from_text(one.get<std::string>(), 2));
  return all;
}

}  // namespace

PublishedAbcDs read_published_abc_ds(const std::string& motion, const std::string& data) {
  const std::string path = data + "/abc_ds/" + motion + "_result.json";
  std::ifstream file(path);
  check(file.good(), "{}: cannot be read, expected the published ABC-DS result", path);
  try {
    const nlohmann::json json = nlohmann::json::parse(file);
    PublishedAbcDs published{polynomials(json.at("f_fh_str_arr")), polynomials(json.at("V_fh_str_arr")),
                             polynomials(json.at("B_fh_str_arr"))};
    check(published.f.size() == 2 && published.V.size() == 1 && published.B.size() == 1,
          "found {}, {} and {} polynomials of f, V and B", published.f.size(), published.V.size(),
          published.B.size());
    published.V = {without_linear_noise(published.V.at(0))};
    return published;
  } catch (const std::exception& error) {
    fail("{}: {}; expected JSON with f_fh_str_arr (2 polynomials), V_fh_str_arr and B_fh_str_arr", path,
         error.what());
  }
}

StateFunction state_function(const std::vector<Polynomial>& outputs) {
  return [outputs](const Points& x) {
    Points y(x.rows(), static_cast<Eigen::Index>(outputs.size()));
    for (std::size_t k = 0; k < outputs.size(); ++k)
      y.col(static_cast<Eigen::Index>(k)) = outputs[k].value(x);
    return y;
  };
}

SafetyProblem on_unit_square(SafetyProblem problem) {
  problem.workspace = Box::cube(2, 1.0);
  problem.workspace_margin = nullptr;
  return problem;
}

ProofResult judge(const PublishedAbcDs& published, const SafetyProblem& problem) {
  const auto peer = [](const std::vector<Polynomial>& p) { return std::make_shared<PolynomialFunction>(p); };
  ProofOptions options;
  options.max_seconds = 120.0;
  return prove(ProofFunctions{peer(published.f), peer(published.V), peer(published.B)},
               on_unit_square(problem), 0.0, options);
}

}  // namespace s2nnds::experiment
