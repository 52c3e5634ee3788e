// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/config.h"

#include <fstream>
#include <sstream>

#include "s2nnds/core/check.h"
#include "s2nnds/runs/smooth_profile.h"

namespace s2nnds {
namespace {

constexpr const char* kAuto = "auto";

}  // namespace

void VerificationOptions::visit(FieldVisitor& v) {
  std::string text(method ? to_string(*method) : kAuto);
  v.field("method", text, {kAuto, "sampled", "conformal", "proof"});
  method = text == kAuto ? std::nullopt : std::optional(enum_from<Method>(text));
  v.group("sampled", sampled);
  v.group("conformal", conformal);
  v.group("proof", proof);
}

void EvaluationOptions::visit(FieldVisitor& v) {
  v.group("rollout", rollout);
  v.field("fidelity", fidelity, above(0.0));
  v.field("area_cells", area_cells, between(0, 2000));
  v.field("grid_points", grid_points, between(3, 1001));
}

void Config::visit(FieldVisitor& v) {
  v.field("name", name);
  const std::string before = profile;
  v.field("profile", profile, {"robust", "smooth", "paper", "imitation"});
  if (profile != before) {  // one was read: the other keys start from its defaults
    const std::string same = name;
    *this = default_config(profile);
    name = same;
  }
  v.field("seed", seed, at_least(0));
  v.group("data", data);
  v.group("problem", problem);
  v.group("networks", networks);
  v.group("training", training);
  if (data.state == "pose") v.group("orientation", orientation);
  v.group("verification", verification);
  v.group("execution", execution);
  v.group("evaluation", evaluation);
}

void Config::choose_for(std::int64_t dimension) {
  const bool fits = execution.is_ideal() && training.margin == 0.0 && networks.f.zero_at_origin &&
                    (networks.V.form == kAuto || networks.V.form == "diffeomorphism");
  networks.choose_forms(dimension > most_proved_dimensions && verification.method != Method::proof && fits);
  if (!verification.method) {
    const bool provable = networks.f.form != "projected" && networks.V.form != "diffeomorphism";
    verification.method = provable ? Method::proof : Method::conformal;
  }
}

void Config::check_forms() const {
  const bool proves = verification.method == Method::proof;
  const bool projected = networks.f.form == "projected";
  check(!proves || !projected,
        "verification.method: found proof with networks.f.form = projected, which the prover does not know; "
        "expected conformal or sampled");
  check(!proves || networks.V.form != "diffeomorphism",
        "verification.method: found proof with networks.V.form = diffeomorphism, which the prover does not "
        "know; expected conformal or sampled");
  if (!projected) return;
  check(networks.V.form == "diffeomorphism",
        "networks.f.form: found projected with networks.V.form = {}, expected diffeomorphism",
        networks.V.form);
  check(networks.f.zero_at_origin,
        "networks.f.form: found projected with zero_at_origin = false, expected true: the goal must be an "
        "equilibrium");
  check(execution.is_ideal() && training.margin == 0.0,
        "networks.f.form: found projected with [execution] or training.margin, which its training does not "
        "know; expected neither");
}

Config default_config(const std::string& profile) {
  Config config;
  config.profile = profile;
  if (profile == "robust") return config;
  if (profile == "smooth") {
    make_smooth(config);
    return config;
  }
  if (profile == "imitation") {
    config.networks.choose_forms(false);
    config.training = imitation_training();
    config.verification.method = Method::sampled;
    return config;
  }
  check(profile == "paper", "profile: found \"{}\", expected robust, smooth, paper or imitation", profile);
  config.problem.workspace = 1.0;
  config.problem.containment = 0.0;
  config.networks = paper_networks();
  config.training = paper_training();
  config.verification.method = Method::conformal;
  return config;
}

Config parse_config(const std::string& text, const std::string& source,
                    const std::vector<std::string>& settings) {
  Config config;
  read_toml(text, source, config, settings);
  return config;
}

std::string read_config_text(const std::string& path) {
  std::ifstream file(path);
  check(file.good(), "{}: cannot read it; expected a configuration file (TOML)", path);
  std::ostringstream text;
  text << file.rdbuf();
  check(!file.bad(), "{}: cannot read it", path);
  // Every key has a default: an empty file would train the shipped example.
  check(text.str().find_first_not_of(" \t\r\n") != std::string::npos,
        "{}: found an empty file; expected a configuration (s2nnds new writes one)", path);
  return text.str();
}

}  // namespace s2nnds
