// What the prover says of the published ABC-DS results: for four LASA motions, polynomials f, V, B learned by
// sums of squares with bilinear matrix inequalities. Each is held to its own sets (the initial ball and the
// polynomial obstacle of configs/abc_ds) on its own workspace [-1, 1]^2, and to the conditions that a
// certificate needs there: V > 0 and Vdot < 0 but at the goal, B <= 0 on X0, B > 0 on the unsafe set, Bdot <
// 0 where B = 0.
//
// Expected (recomputed over all seven demonstrations, normalised by the largest norms):
//   motion   MSE     SD      safe area in [-1, 1]^2 of 4
//   Sine     0.0257  0.0835  2.851
//   Sshape   0.0137  0.0636  3.748
//   Worm     0.0634  0.1296  3.176
//   PShape   0.0464  0.1124  3.070
//
// Usage: abc_ds_claims [--data DIR] [--configs DIR] [--out FILE.json]
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "s2nnds/core/check.h"
#include "s2nnds/evaluation/safe_area.h"
#include "s2nnds/evaluation/trajectory_metrics.h"
#include "s2nnds/problem/polynomial.h"
#include "s2nnds/runs/pipeline.h"
#include "s2nnds/verification/polynomial_function.h"
#include "s2nnds/verification/prover.h"

namespace {

using namespace s2nnds;

struct Published {
  std::vector<Polynomial> f, V, B;
};

// The solver leaves linear terms below 1e-15 in V, by which V < 0 somewhere arbitrarily near the goal. They
// are noise, and are dropped here: what is judged is the V that was meant.
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

Published read_published(const std::string& path) {
  std::ifstream file(path);
  check(file.good(), "{}: cannot be read, expected the published ABC-DS result", path);
  const nlohmann::json json = nlohmann::json::parse(file);
  Published published{polynomials(json.at("f_fh_str_arr")), polynomials(json.at("V_fh_str_arr")),
                      polynomials(json.at("B_fh_str_arr"))};
  published.V = {without_linear_noise(published.V.at(0))};
  return published;
}

Points values(const std::vector<Polynomial>& f, const Points& x) {
  Points y(x.rows(), static_cast<Eigen::Index>(f.size()));
  for (std::size_t k = 0; k < f.size(); ++k) y.col(static_cast<Eigen::Index>(k)) = f[k].value(x);
  return y;
}

nlohmann::json judge(const std::string& motion, const std::string& config_path, const std::string& data) {
  Setup setup = set_up(parse_config(read_config_text(config_path, {}), config_path), data);
  setup.problem.workspace =
      Box::cube(2, 1.0);  // which some initial balls leave by a little: that part is not judged
  setup.problem.shell = nullptr;
  const Published published = read_published(data + "/abc_ds/" + motion + "_result.json");
  const Points position = stack_positions(setup.demonstrations),
               velocity = stack_velocities(setup.demonstrations);
  const Points predicted = values(published.f, position);
  const auto level = [&](const Points& x) { return published.B.at(0).value(x); };
  nlohmann::json row = {{"motion", motion},
                        {"mse", mean_squared_error(predicted, velocity)},
                        {"sd", error_deviation(predicted, velocity)},
                        {"safe_area", sublevel_area(level, Box::cube(2, 1.0), 400)}};

  const auto peer = [](const std::vector<Polynomial>& p) { return std::make_shared<PolynomialFunction>(p); };
  ProofOptions options;
  options.max_seconds = 120.0;
  const ProofResult proof = prove(ProofFunctions{peer(published.f), peer(published.V), peer(published.B)},
                                  setup.problem, 0.0, options);
  row["proof_seconds"] = proof.seconds;
  row["goal_cube"] = proof.goal_cube;
  for (const ConditionProof& condition : proof.conditions) {
    const ConditionVerdict& verdict = condition.verdict;
    row["conditions"][verdict.condition] = {
        {"verdict", verdict.verdict},         {"boxes", verdict.boxes},
        {"open_volume", verdict.open_volume}, {"open_boxes", verdict.open_boxes},
        {"witness", verdict.witness},         {"worst", verdict.worst}};
  }
  return row;
}

void print(const nlohmann::json& row) {
  fmt::print("{:8} mse {:.4f}  sd {:.4f}  safe area {:.3f}  proof {:.2f} s\n",
             row["motion"].get<std::string>(), row["mse"].get<double>(), row["sd"].get<double>(),
             row["safe_area"].get<double>(), row["proof_seconds"].get<double>());
  for (const auto& [name, verdict] : row["conditions"].items()) {
    fmt::print("  {:18} {:10} boxes {}", name, verdict["verdict"].get<std::string>(),
               verdict["boxes"].get<std::int64_t>());
    const auto witness = verdict["witness"].get<std::vector<double>>();
    if (!witness.empty())
      fmt::print("  violated by {:.3g} at ({:.6g}, {:.6g})", verdict["worst"].get<double>(), witness[0],
                 witness[1]);
    if (verdict["verdict"] == "undecided")
      fmt::print("  open boxes {}, area {:.3g}", verdict["open_boxes"].get<std::int64_t>(),
                 verdict["open_volume"].get<double>());
    fmt::print("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"What the prover says of the published ABC-DS polynomials"};
  std::string data = "../shared/data", configs = "experiments/configs/abc_ds", out;
  app.add_option("--data", data, "folder of the data");
  app.add_option("--configs", configs, "folder of the problems");
  app.add_option("--out", out, "JSON file for the results");
  CLI11_PARSE(app, argc, argv);
  try {
    nlohmann::json table = nlohmann::json::array();
    for (const char* motion : {"Sine", "Sshape", "Worm", "PShape"}) {
      table.push_back(judge(motion, configs + "/" + motion + ".toml", data));
      print(table.back());
    }
    if (!out.empty()) std::ofstream(out) << table.dump(2) << "\n";
  } catch (const Error& error) {
    fmt::print(stderr, "abc_ds_claims: {}\n", error.what());
    return 2;
  }
  return 0;
}
