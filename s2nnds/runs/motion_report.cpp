// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/motion_report.h"

#include <algorithm>
#include <cmath>

#include "s2nnds/core/random.h"
#include "s2nnds/data/survey.h"
#include "s2nnds/evaluation/topology.h"
#include "s2nnds/runs/user_units.h"

namespace s2nnds {
namespace {

std::vector<double> numbers(const Vector& x) { return {x.begin(), x.end()}; }

// "2", "2 and 5", "2, 5 and 7"
std::string listed(const std::vector<std::int64_t>& items) {
  std::string text;
  for (std::size_t k = 0; k < items.size(); ++k)
    text += fmt::format("{}{}", k == 0 ? "" : k + 1 == items.size() ? " and " : ", ", items[k]);
  return text;
}

// What recordings k show that no law x' = f(x) can do; empty where nothing is seen.
std::string reason_of(const PreparedRun& setup, const RunRecord& record,
                      const std::vector<std::int64_t>& members) {
  const Survey found = survey({.name = record.name, .unit = "", .demonstrations = setup.data.demonstrations});
  const auto is_member = [&](std::size_t k) {
    return std::find(members.begin(), members.end(), static_cast<std::int64_t>(k)) != members.end();
  };
  const Frame& frame = setup.data.frame;
  for (const std::int64_t k : members) {
    if (found.is_closed(k)) return fmt::format(": demonstration {} ends where it starts", k);
  }
  for (const Crossing& crossing : found.crossings) {
    if (!is_member(crossing.first) && !is_member(crossing.second)) continue;
    const std::string place = frame.position_text(crossing.place);
    if (crossing.first == crossing.second)
      return fmt::format(": demonstration {} comes back to {}, where f has one velocity", crossing.first,
                         place);
    return fmt::format(": demonstrations {} and {} cross at {}, where f has one velocity", crossing.first,
                       crossing.second, place);
  }
  for (const std::int64_t k : members) {
    const Demonstration& shown = setup.demonstrations[static_cast<std::size_t>(k)];
    if (setup.problem.unsafe->level(shown.position).minCoeff() <= 0.0)
      return fmt::format(": demonstration {} passes through the obstacle", k);
  }
  return "";
}

std::string fidelity_remark(const PreparedRun& setup, const RunRecord& record,
                            const std::vector<Deviation>& deviations) {
  const UserUnits units(record);
  std::vector<std::int64_t> strays;
  double largest = 0.0, mean = 0.0, limit = 0.0;
  for (std::size_t k = 0; k < deviations.size(); ++k) {
    largest = std::max(largest, deviations[k].largest);
    mean = std::max(mean, deviations[k].mean);
    if (deviations[k].follows()) continue;
    strays.push_back(setup.data.split.train[k]);
    limit = std::max(limit, deviations[k].limit);
  }
  if (strays.empty()) {
    return fmt::format("The motion follows the training demonstrations within {} ({} on average at most).",
                       units.length(largest), units.length(mean));
  }
  return fmt::format(
      "The motion does NOT follow demonstration{} {}: it is {} away on average, {} at most are expected{}.",
      strays.size() > 1 ? "s" : "", listed(strays), units.length(mean), units.length(limit),
      reason_of(setup, record, strays));
}

// Motions from the initial set that take another way than any demonstration; empty where none of those looked
// at does.
std::string initial_set_remark(const RunRecord& record, const std::vector<Deviation>& deviations) {
  std::int64_t strays = 0;
  const Deviation* worst = nullptr;
  for (const Deviation& each : deviations) {
    if (each.follows()) continue;
    ++strays;
    if (!worst || !(each.mean / each.limit <= worst->mean / worst->limit)) worst = &each;
  }
  if (strays == 0) return "";
  const UserUnits units(record);
  return fmt::format(
      "From {} of {} starts in the initial set the motion does NOT follow any demonstration: it is {} away "
      "on "
      "average, {} at most are expected.",
      strays, deviations.size(), units.length(worst->mean), units.length(worst->limit));
}

Points starts_of(const PreparedRun& setup, const std::vector<Demonstration>& shown, std::int64_t draw) {
  constexpr std::int64_t kStarts = 32;
  RandomStream random(setup.config.seed, "fidelity/starts", draw);
  return spread_starts(setup.problem, shown, kStarts, random);
}

// The nearest of what can be in the way at x [n], normalised.
std::string neighbour_of(const PreparedRun& setup, const Vector& x) {
  const Points at = x.transpose();
  const double obstacle = setup.problem.unsafe->level(at)[0], initial = setup.problem.initial->level(at)[0];
  if (x.norm() < 0.1) return "near the goal";
  if (obstacle < 0.1 && initial < 0.1) return "between the initial set and the obstacle";
  if (obstacle < 0.1) return "beside the obstacle";
  if (initial < 0.1) return "beside the initial set";
  if (!setup.problem.contained.contains(1.05 * x)) return "at the workspace's edge";
  return "away from the obstacle";
}

// Where conditions are left open or violated.
void add_open_places(const PreparedRun& setup, const RunRecord& record, std::vector<std::string>& remarks) {
  const UserUnits units(record);
  const Eigen::Index n = setup.problem.dimension();
  for (const auto& [name, corners] : record.open_boxes) {
    if (corners.rows() == 0) continue;
    const Vector middle = 0.5 * (corners.leftCols(n) + corners.rightCols(n)).row(0).transpose();
    remarks.push_back(fmt::format("{} was left open in {} boxes, as at {}, {}.", name, corners.rows(),
                                  units.position(numbers(middle)), neighbour_of(setup, middle)));
  }
}

// Places of demonstrations nearer to the obstacle than this do not count: motions are turned aside there. In many
// dimensions, where a box of any size around a place may meet the obstacle, all count that lie off it.
double obstacle_margin(const PreparedRun& setup) {
  return setup.problem.dimension() > few_dimensions ? 0.0 : 2.0 * setup.config.training.obstacle_margin;
}

}  // namespace

std::vector<Deviation> deviations_of(const PreparedRun& setup, const StateFunction& f) {
  return deviations(f, setup.problem, setup.train(), setup.config.evaluation.fidelity, obstacle_margin(setup),
                    setup.config.evaluation.rollout);
}

std::vector<Deviation> start_deviations_of(const PreparedRun& setup, const Dynamics& f, std::int64_t draw) {
  const std::vector<Demonstration> shown = setup.train();
  return start_deviations(f, setup.problem, shown, starts_of(setup, shown, draw),
                          setup.config.evaluation.fidelity, obstacle_margin(setup),
                          setup.config.evaluation.rollout);
}

double worst_deviation(const PreparedRun& setup, const Dynamics& f, std::int64_t draw) {
  return std::max(worst_share(deviations_of(setup, f)), worst_share(start_deviations_of(setup, f, draw)));
}

VelocityTargets corrections_of(const PreparedRun& setup, const Dynamics& f, std::int64_t draw) {
  const std::vector<Demonstration> shown = setup.train();
  return corrections_of(f, setup.problem, shown, starts_of(setup, shown, draw),
                        setup.config.evaluation.fidelity, obstacle_margin(setup),
                        setup.config.evaluation.rollout);
}

bool follows_demonstrations(const RunRecord& record) {
  return !(record.evaluation.not_followed > 0.0) && !(record.evaluation.starts_not_followed > 0.0);
}

std::vector<std::string> topology_remarks(const PreparedRun& setup, const RunRecord& record) {
  const Topology found = find_topology(record.networks.dynamics(), record.networks.B, setup.problem);
  const UserUnits units(record);
  std::vector<std::string> remarks;
  for (const Island& island : found.islands) {
    remarks.push_back(fmt::format(
        "{{B > 0}} has an island {} {}: motions that converge cannot leave one out, so no certificate can "
        "exist with it; a tail from it to the workspace's edge is needed.",
        island.holds_obstacle ? "around the obstacle at" : "at", units.position(numbers(island.place))));
  }
  for (const Fragment& fragment : found.fragments) {
    remarks.push_back(
        fmt::format("{{B <= 0}} has a part at {} that does not reach the goal: its motions cannot arrive, so "
                    "no certificate can exist with it.",
                    units.position(numbers(fragment.place))));
  }
  for (const Equilibrium& rest : found.equilibria) {
    remarks.push_back(fmt::format("f stands still at {} ({}{}), where V cannot fall.",
                                  units.position(numbers(rest.place)),
                                  rest.index < 0 ? "a saddle" : "a source, sink or centre",
                                  rest.in_obstacle ? " in the obstacle" : ""));
  }
  constexpr std::size_t kShown = 4;
  if (remarks.size() > kShown) remarks.resize(kShown);
  return remarks;
}

std::vector<std::string> motion_remarks(const PreparedRun& setup, const RunRecord& record,
                                        const std::vector<Deviation>& from_shown,
                                        const std::vector<Deviation>& from_initial) {
  std::vector<std::string> remarks = {fidelity_remark(setup, record, from_shown)};
  if (std::string strays = initial_set_remark(record, from_initial); !strays.empty())
    remarks.push_back(std::move(strays));
  if (record.certificate.guarantee >= Guarantee::proved || setup.config.verification.method != Method::proof)
    return remarks;
  for (std::string& remark : topology_remarks(setup, record)) remarks.push_back(std::move(remark));
  add_open_places(setup, record, remarks);
  return remarks;
}

}  // namespace s2nnds
