#include "published_abc_ds.h"

#include <array>
#include <boost/numeric/odeint.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "s2nnds/core/check.h"
#include "s2nnds/evaluation/rollout.h"
#include "s2nnds/evaluation/safe_area.h"
#include "s2nnds/evaluation/trajectory_metrics.h"
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

Points PublishedAbcDs::velocity(const Points& x) const {
  Points y(x.rows(), static_cast<Eigen::Index>(f.size()));
  for (std::size_t k = 0; k < f.size(); ++k) y.col(static_cast<Eigen::Index>(k)) = f[k].value(x);
  return y;
}

Points PublishedAbcDs::roll_out_at(const Vector& start, const Vector& times) const {
  using State = std::array<double, 2>;
  const auto system = [&](const State& x, State& velocity_there, double) {
    const Points v = velocity(Eigen::Map<const Points>(x.data(), 1, 2));
    velocity_there = {v(0, 0), v(0, 1)};
  };
  State state = {start[0], start[1]};
  Points path(times.size(), 2);
  Eigen::Index row = 0;
  namespace odeint = boost::numeric::odeint;
  odeint::integrate_times(odeint::make_dense_output(1e-6, 1e-6, odeint::runge_kutta_dopri5<State>()), system,
                          state, times.begin(), times.end(), 1e-3,
                          [&](const State& x, double) { path.row(row++) << x[0], x[1]; });
  return path;
}

double PublishedAbcDs::true_safe_area(const SafetyProblem& problem) const {
  constexpr Eigen::Index kCells = 100;
  constexpr double kStep = 0.03, kDuration = 40.0, kGoalRadius = 0.02;
  Points x(kCells * kCells, 2);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    x.row(i) << (2.0 * static_cast<double>(i / kCells) + 1.0) / kCells - 1.0,
        (2.0 * static_cast<double>(i % kCells) + 1.0) / kCells - 1.0;
  Eigen::Index arrived = 0;
  for (double time = 0.0; time < kDuration && x.rows() > 0; time += kStep) {
    // Those that left the square first: a polynomial is not a number far away.
    std::vector<Eigen::Index> inside, going;
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      if (x.row(i).cwiseAbs().maxCoeff() <= 1.0) inside.push_back(i);
    }
    x = x(inside, Eigen::all).eval();
    const Vector level = problem.unsafe->level(x);
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      if (!(level[i] > 0.0)) continue;
      if (x.row(i).norm() <= kGoalRadius) {
        ++arrived;
      } else {
        going.push_back(i);
      }
    }
    x = x(going, Eigen::all).eval();
    const Points k1 = velocity(x), k2 = velocity(x + 0.5 * kStep * k1), k3 = velocity(x + 0.5 * kStep * k2),
                 k4 = velocity(x + kStep * k3);
    x += kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return 4.0 * static_cast<double>(arrived) / static_cast<double>(kCells * kCells);
}

double PublishedAbcDs::safe_area() const {
  return sublevel_area([&](const Points& x) { return B.at(0).value(x); }, Box::cube(2, 1.0), 400);
}

ProofResult judge(const PublishedAbcDs& published, SafetyProblem problem) {
  problem.workspace = Box::cube(2, 1.0);  // which some initial balls leave by a little: that is not judged
  problem.workspace_margin = nullptr;
  const auto peer = [](const std::vector<Polynomial>& p) { return std::make_shared<PolynomialFunction>(p); };
  ProofOptions options;
  options.max_seconds = 120.0;
  return prove(ProofFunctions{peer(published.f), peer(published.V), peer(published.B)}, problem, 0.0,
               options);
}

}  // namespace s2nnds::experiment
