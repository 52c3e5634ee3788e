// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/adaptation.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "s2nnds/core/check.h"
#include "s2nnds/core/settings.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/runs/evaluation_run.h"
#include "s2nnds/runs/motion_report.h"
#include "s2nnds/runs/training_checkpoint.h"
#include "s2nnds/runs/training_run.h"
#include "s2nnds/runs/verification_run.h"

namespace s2nnds {
namespace {

// Of the rounds that go on from the old networks. Most of what they must do is near the old B.
constexpr std::int64_t kRounds = 10, kBarrierRounds = 1, kSteps = 120, kLabels = 1500;

bool names(const std::string& setting, const std::string& key) { return setting.starts_with(key + "="); }

bool names_demonstrations(const std::string& setting) {
  constexpr const char* keys[] = {"data.files", "data.use", "data.test", "data.validation"};
  return std::any_of(std::begin(keys), std::end(keys), [&](const char* key) { return names(setting, key); });
}

void check_settings(const std::vector<std::string>& settings) {
  check(!settings.empty(),
        "adapt: found no settings, expected what changes, such as problem.unsafe.center=[0.1, 0.2]");
  for (const std::string& setting : settings) {
    check(setting.starts_with("problem.") || names(setting, "data.goal") || names_demonstrations(setting),
          "adapt: found the setting \"{}\", expected keys below problem., data.goal, or which demonstrations "
          "there are (data.files, use, test, validation); `train` makes other motions",
          setting);
  }
}

// The demonstrations that the configuration names now, seen in the old run's frame: the networks know no other.
void read_again(const Config& config, const std::string& data_dir, RunData& data) {
  check(!data.frame.has_phase(),
        "adapt: found other demonstrations for a run whose states have a phase; expected those that it has: "
        "`train` learns from others");
  DemonstrationSet as_read = read_demonstrations(config.data, data_dir);
  check(as_read.dimension() == data.dimension,
        "adapt: found demonstrations in {} dimensions, expected {} as before", as_read.dimension(),
        data.dimension);
  const Frame old = data.frame;
  const WordOrNumbers same_goal{.word = "", .numbers = {old.goal.begin(), old.goal.end()}};
  data.frame =
      find_frame(as_read, old.normalization, old.moves_demonstrations() ? WordOrNumbers{"each"} : same_goal);
  data.frame.name = old.name;
  data.frame.goal = old.goal;
  data.frame.goal_orientation = old.goal_orientation;
  data.frame.position_scale = old.position_scale;
  data.frame.velocity_scale = old.velocity_scale;
  data.split = split_demonstrations(as_read.demonstrations.size(), config.data.test, config.data.validation);
  data.demonstrations = std::move(as_read.demonstrations);
  data.report = std::move(as_read.report);
}

// The old run's demonstrations and frame, as far as the settings do not change them. Where the goal moves, the motion moves
// with it: in normalised units the scene moves the other way.
RunData changed_data(const RunRecord& old, const Config& config, const std::vector<std::string>& settings,
                     const std::string& data_dir) {
  RunData data = old.data;
  if (std::any_of(settings.begin(), settings.end(), names_demonstrations)) read_again(config, data_dir, data);
  if (std::any_of(settings.begin(), settings.end(),
                  [](const auto& each) { return names(each, "data.goal"); })) {
    const std::vector<double>& goal = config.data.goal.numbers;
    const Eigen::Index places = data.frame.places();
    check(config.data.goal.word.empty() && std::ssize(goal) == places &&
              std::all_of(goal.begin(), goal.end(), [](double x) { return std::isfinite(x); }),
          "adapt: data.goal: found something else than a point, expected {} finite coordinates", places);
    data.frame.goal.head(places) = Eigen::Map<const Vector>(goal.data(), places);
  }
  return data;
}

bool is_certified(const PreparedRun& setup, const RunRecord& record) {
  return record.certificate.guarantee >=
         (setup.problem.workspace_margin ? Guarantee::invariant : Guarantee::proved);
}

void prove(const PreparedRun& setup, RunRecord& record) {
  verify(setup, record, Method::proof, setup.config.verification);
}

// Distances along both paths, matched in order.
double change_of_motion(const PreparedRun& setup, const Dynamics& before, const Dynamics& after) {
  std::vector<Demonstration> motions = setup.train();
  for (Demonstration& motion : motions) {
    const Rollout rollout =
        roll_out(before, setup.problem, motion.position.row(0).transpose(), {.stop_at_unsafe = false});
    motion.time = rollout.time;
    motion.position = rollout.position;
    motion.velocity = Points::Zero(rollout.position.rows(), rollout.position.cols());
  }
  double largest = 0.0;
  for (const Deviation& each : deviations(after, setup.problem, motions, 1.0, 0.0))
    largest = std::max(largest, each.largest);
  return largest;
}

class Adapter {
 public:
  Adapter(const RunRecord& old, PreparedRun setup, std::string text, const AdaptationHooks& hooks)
      : old_(old), setup_(std::move(setup)), text_(std::move(text)), hooks_(hooks) {}

  AdaptationResult run() {
    RunRecord record = fresh();
    record.networks = old_.networks;
    record.orientation = old_.orientation;
    if (old_.checkpoint) record.checkpoint = old_.checkpoint, record.history = old_.history;
    prove(setup_, record);
    if (is_certified(setup_, record) && follows(record.networks))
      return finish(std::move(record), Adaptation::held);
    if (cancelled()) return finish(std::move(record), Adaptation::failed);
    record = go_on();
    if (is_certified(setup_, record) && follows(record.networks))
      return finish(std::move(record), Adaptation::adapted);
    if (cancelled()) return finish(std::move(record), Adaptation::failed);
    record = fresh();
    train(setup_, record, hooks());
    prove(setup_, record);
    const bool certified = is_certified(setup_, record) && follows(record.networks);
    return finish(std::move(record), certified ? Adaptation::anew : Adaptation::failed);
  }

 private:
  RunRecord fresh() const { return new_record(setup_, text_); }
  bool cancelled() const { return hooks_.cancelled && hooks_.cancelled(); }

  TrainingHooks hooks() const {
    return {.progress = hooks_.progress,
            .checkpoint = {},
            .cancelled = hooks_.cancelled,
            .until_certified = true};
  }

  bool follows(const Networks& networks) const { return worst_deviation(setup_, networks.dynamics()) <= 1.0; }

  // From the old networks: B alone, then all three.
  RunRecord go_on() const {
    PreparedRun quick = setup_;
    TrainerOptions& training = quick.config.training;
    training.rounds = kRounds;
    training.barrier_rounds = follows(old_.networks) ? kBarrierRounds : 0;
    training.steps = training.enlarge_steps = kSteps;
    training.rollout_points = std::min(training.rollout_points, kLabels);
    training.rate_period = 0;
    RunRecord record = fresh();
    const Points none(0, quick.problem.dimension());
    store_trainer_state({old_.networks, {none, none, none}, {RoundSummary{}}}, record);
    train(quick, record, hooks());
    prove(setup_, record);
    return record;
  }

  AdaptationResult finish(RunRecord record, Adaptation outcome) const {
    evaluate_motion(setup_, record);
    AdaptationResult result;
    result.outcome = outcome;
    result.seconds = watch_.seconds();
    result.motion_change = change_of_motion(setup_, old_.networks.dynamics(), record.networks.dynamics());
    result.record = std::move(record);
    return result;
  }

  const Stopwatch watch_;
  const RunRecord& old_;
  PreparedRun setup_;
  std::string text_;
  const AdaptationHooks& hooks_;
};

}  // namespace

std::string_view to_string(Adaptation adaptation) {
  switch (adaptation) {
    case Adaptation::held:
      return "held";
    case Adaptation::adapted:
      return "adapted";
    case Adaptation::anew:
      return "anew";
    case Adaptation::failed:
      return "failed";
  }
  return "";
}

AdaptationResult adapt(const RunRecord& old, const std::vector<std::string>& settings,
                       const std::string& data_dir, const AdaptationHooks& hooks) {
  check_settings(settings);
  const std::string text = with_settings(old.config.resolved, "the run's configuration", settings);
  const Config config = parse_config(text, "the run's configuration");
  const bool names_files = std::any_of(settings.begin(), settings.end(), [](const std::string& setting) {
    return setting.starts_with("problem.") && setting.find("file") != std::string::npos;
  });
  RegionFiles files = names_files ? RegionFiles(data_dir) : RegionFiles(old.problem.files);
  PreparedRun setup = prepare(config, changed_data(old, config, settings, data_dir), std::move(files));
  return Adapter(old, std::move(setup), text, hooks).run();
}

}  // namespace s2nnds
