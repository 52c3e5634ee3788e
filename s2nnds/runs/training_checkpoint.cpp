// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/training_checkpoint.h"

#include <cstdint>
#include <functional>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

struct Column {
  std::string name;
  std::function<double(const RoundSummary&)> get;
  std::function<void(RoundSummary&, double)> set;
};

template <typename T>
Column column(const std::string& name, T RoundSummary::*member) {
  return {name, [=](const RoundSummary& row) { return static_cast<double>(row.*member); },
          [=](RoundSummary& row, double value) { row.*member = static_cast<T>(value); }};
}

constexpr const char* kNewest = "volume";  // files of earlier programs lack it

std::vector<Column> columns() {
  std::vector<Column> all = {column("round", &RoundSummary::round), column("loss", &RoundSummary::loss),
                             column("mse", &RoundSummary::mse)};
  for (const LossTerm term : all_loss_terms) {
    all.push_back({std::string(to_string(term)),
                   [=](const RoundSummary& row) { return row.loss_terms[term]; },
                   [=](RoundSummary& row, double value) { row.loss_terms[term] = value; }});
  }
  for (std::size_t q = 0; q < all_conditions.size(); ++q) {
    all.push_back(
        {fmt::format("count_{}", to_string(all_conditions[q])),
         [q](const RoundSummary& row) { return static_cast<double>(row.counts[q]); },
         [q](RoundSummary& row, double value) { row.counts[q] = static_cast<std::int64_t>(value); }});
  }
  all.push_back(column("found_by_sampling", &RoundSummary::found_by_sampling));
  all.push_back(column("pool", &RoundSummary::pool));
  all.push_back(column("safe_share", &RoundSummary::safe_share));
  all.push_back(column(kNewest, &RoundSummary::volume));
  all.push_back(column("deviation", &RoundSummary::deviation));
  all.push_back(column("islands", &RoundSummary::islands));
  all.push_back(column("equilibria", &RoundSummary::equilibria));
  all.push_back(column("stage", &RoundSummary::stage));
  all.push_back(column("seconds", &RoundSummary::seconds));
  return all;
}

Points points_named(const Checkpoint& checkpoint, const std::string& name, std::int64_t dimension) {
  for (const auto& [known, points] : checkpoint.points) {
    if (known != name) continue;
    check(points.cols() == dimension, "run file: /checkpoint/points/{} has {} columns, expected {}", name,
          points.cols(), dimension);
    return points;
  }
  fail("run file: /checkpoint/points/{} is missing", name);
}

}  // namespace

void store_trainer_state(const TrainerState& state, RunRecord& record) {
  record.networks = state.networks;
  record.history.clear();
  const auto rows = static_cast<Eigen::Index>(state.history.size());
  for (const Column& column : columns()) {
    Vector values(rows);
    for (Eigen::Index i = 0; i < rows; ++i) values[i] = column.get(state.history[i]);
    record.history.emplace_back(column.name, values);
  }
  Checkpoint checkpoint;
  checkpoint.round = state.history.empty() ? 0 : state.history.back().round;
  checkpoint.points = {{"pool_workspace", state.pools.workspace},
                       {"pool_initial", state.pools.initial},
                       {"pool_unsafe", state.pools.unsafe}};
  record.checkpoint = checkpoint;
}

TrainerState to_trainer_state(const RunRecord& record) {
  check(record.checkpoint.has_value(), "run file: found no /checkpoint, so training cannot be resumed");
  TrainerState state;
  state.networks = record.networks;
  const Checkpoint& checkpoint = *record.checkpoint;
  state.pools = {points_named(checkpoint, "pool_workspace", record.data.dimension),
                 points_named(checkpoint, "pool_initial", record.data.dimension),
                 points_named(checkpoint, "pool_unsafe", record.data.dimension)};
  state.history.resize(checkpoint.round + 1);
  for (const Column& column : columns()) {
    const Vector* values = nullptr;
    for (const auto& [name, stored] : record.history) {
      if (name == column.name) values = &stored;
    }
    if (values == nullptr && column.name == kNewest) continue;
    check(values != nullptr && values->size() == checkpoint.round + 1,
          "run file: /history/{} has {} rows, expected {}", column.name, values ? values->size() : 0,
          checkpoint.round + 1);
    for (std::size_t i = 0; i < state.history.size(); ++i) column.set(state.history[i], (*values)[i]);
  }
  return state;
}

}  // namespace s2nnds
