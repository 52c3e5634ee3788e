// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/certified_scope.h"

#include "s2nnds/core/check.h"
#include "s2nnds/core/sha256.h"

namespace s2nnds {
namespace {

std::vector<double> numbers(const Vector& x) { return {x.begin(), x.end()}; }

struct ScopeFrame {
  std::string unit, name;
  std::vector<double> goal;
  double position_scale = 1.0, velocity_scale = 1.0;

  void visit(FieldVisitor& v) {
    v.field("unit", unit);
    v.field("name", name);
    v.field("goal", goal, any_number());
    v.field("position_scale", position_scale, above(0.0));
    v.field("velocity_scale", velocity_scale, above(0.0));
  }
};

struct ScopeFile {
  std::string name, digest;

  void visit(FieldVisitor& v) {
    v.field("name", name);
    v.field("sha256", digest);
  }
};

struct ScopeProblem {
  std::string frame;
  std::vector<double> workspace_lower, workspace_upper, contained_lower, contained_upper;
  double level_band = 0.0;
  RegionOptions initial, unsafe;
  std::vector<ScopeFile> files;

  void visit(FieldVisitor& v) {
    v.field("frame", frame);
    v.field("workspace_lower", workspace_lower, any_number());
    v.field("workspace_upper", workspace_upper, any_number());
    v.field("contained_lower", contained_lower, any_number());
    v.field("contained_upper", contained_upper, any_number());
    v.field("level_band", level_band, at_least(0.0));
    v.group("initial", initial);
    v.group("unsafe", unsafe);
    v.list("files", files);
  }
};

struct ScopeOrientation {
  std::string psi, quaternion_order;
  std::vector<double> goal;
  double rate = 0.0, initial_error = 0.0;

  void visit(FieldVisitor& v) {
    v.field("psi", psi);
    v.field("quaternion_order", quaternion_order);
    v.field("goal", goal, any_number());
    v.field("rate", rate, at_least(0.0));
    v.field("initial_error", initial_error, at_least(0.0));
  }
};

struct Scope {
  std::string weights;
  ScopeFrame frame;
  ScopeProblem problem;
  ExecutionOptions execution;
  ScopeOrientation orientation;

  void visit(FieldVisitor& v) {
    v.field("weights", weights);
    v.group("frame", frame);
    v.group("problem", problem);
    if (!execution.is_ideal() || execution.damping > 0.0) v.group("execution", execution);
    if (!orientation.quaternion_order.empty()) v.group("orientation", orientation);
  }
};

// Times do not belong to what was found: the same run has the same seal.
std::string seal_of(Certificate certificate) {
  certificate.seal.clear();
  for (ConditionVerdict& verdict : certificate.conditions) verdict.seconds = 0.0;
  return sha256(to_json(certificate));
}

// What is shown of the problem is what the configuration makes.
bool same_words(const RunProblem& a, const RunProblem& b) {
  return a.frame == b.frame && a.unsafe == b.unsafe && a.initial == b.initial &&
         a.containment == b.containment && a.level_band == b.level_band &&
         a.workspace.lower == b.workspace.lower && a.workspace.upper == b.workspace.upper;
}

bool is_of_the_run(const PreparedRun& setup, const RunRecord& record) {
  return record.certificate.scope == certified_scope(setup, record) &&
         same_words(record.problem, new_record(setup, "").problem);
}

bool claims_anything(const Certificate& certificate) {
  return certificate.guarantee != Guarantee::none || certificate.stability.proved ||
         !certificate.conditions.empty();
}

}  // namespace

std::string certified_scope(const PreparedRun& setup, const RunRecord& record) {
  const SafetyProblem& problem = setup.problem;
  const Frame& frame = setup.data.frame;
  Scope scope;
  scope.weights = weight_hash(record.networks);
  scope.frame = {frame.unit, frame.name, numbers(frame.goal), frame.position_scale, frame.velocity_scale};
  scope.problem = {.frame = setup.config.problem.frame,
                   .workspace_lower = numbers(problem.workspace.lower),
                   .workspace_upper = numbers(problem.workspace.upper),
                   .contained_lower = numbers(problem.contained.lower),
                   .contained_upper = numbers(problem.contained.upper),
                   .level_band = setup.config.training.level_band,
                   .initial = problem.written_initial,
                   .unsafe = problem.written_unsafe,
                   .files = {}};
  for (const auto& [name, bytes] : setup.files.all()) scope.problem.files.push_back({name, sha256(bytes)});
  scope.execution = setup.config.execution;
  if (frame.has_orientation()) {
    scope.orientation.quaternion_order = frame.quaternion_order;
    scope.orientation.goal = numbers(frame.goal_orientation);
    if (record.orientation) {
      scope.orientation.psi = record.orientation->hash();
      scope.orientation.rate = record.orientation->rate;
      scope.orientation.initial_error = record.orientation->initial_error;
    }
  }
  return to_toml(scope);
}

void seal_certificate(const PreparedRun& setup, RunRecord& record) {
  record.certificate.scope = certified_scope(setup, record);
  record.certificate.seal = seal_of(record.certificate);
}

bool is_intact(const PreparedRun& setup, const RunRecord& record) {
  return is_of_the_run(setup, record) && record.certificate.seal == seal_of(record.certificate);
}

void check_certificate(const RunRecord& record, const std::string& path) {
  if (!claims_anything(record.certificate)) return;
  const PreparedRun setup = prepare(record);
  check(is_of_the_run(setup, record),
        "{}: found weights, a problem or data other than those that its certificate speaks of; "
        "`s2nnds verify` makes a new one",
        path);
  check(is_intact(setup, record),
        "{}: found a certificate whose figures were changed; `s2nnds verify` makes a new one", path);
}

RunRecord load_certified_run(const std::string& path) {
  RunRecord record = load_run(path);
  check_certificate(record, path);
  return record;
}

}  // namespace s2nnds
