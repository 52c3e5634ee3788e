// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/result_table.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>

#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/hdf5.h"

namespace s2nnds {
namespace {

struct Row {
  Trial trial;
  const TrialResult* result = nullptr;  // null: missing
};

std::vector<Row> rows_of(const Sweep& sweep, const SweepState& state) {
  std::map<std::int64_t, const TrialResult*> all;
  for (const TrialResult& result : state.results) all[result.trial] = &result;
  for (const std::int64_t trial : state.missing) all[trial] = nullptr;
  std::vector<Row> rows;
  for (const auto& [trial, result] : all) rows.push_back({sweep.trial(trial), result});
  return rows;
}

struct Column {
  std::string name;
  bool is_text = false;
  std::vector<std::string> cells;  // numbers with all their digits; empty: not measured
};

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

// TOML strings lose their quotes, all else stays as it is written.
std::string plain(const std::string& toml) {
  const bool quoted =
      toml.size() >= 2 && (toml.front() == '"' || toml.front() == '\'') && toml.back() == toml.front();
  return quoted ? toml.substr(1, toml.size() - 2) : toml;
}

bool is_number(const std::string& text) {
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0';
}

// In the order in which they first appear.
std::vector<std::string> metric_names(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  std::map<std::string, bool> seen;
  for (const Row& row : rows) {
    if (row.result == nullptr) continue;
    for (const auto& metric : row.result->metrics) {
      if (!std::exchange(seen[metric.first], true)) names.push_back(metric.first);
    }
  }
  return names;
}

std::vector<Column> columns_of(const Sweep& sweep, const SweepState& state) {
  const std::vector<Row> rows = rows_of(sweep, state);
  std::vector<Column> columns;
  const auto add = [&](const std::string& name, bool is_text, const auto& cell) {
    columns.push_back({name, is_text, {}});
    for (const Row& row : rows) columns.back().cells.push_back(cell(row));
  };
  const auto of_result = [&](const std::string& name, bool is_text, const auto& cell) {
    add(name, is_text, [&](const Row& row) { return row.result == nullptr ? "" : cell(*row.result); });
  };
  add("trial", false, [](const Row& row) { return std::to_string(row.trial.id); });
  add("rung", false, [](const Row& row) { return std::to_string(row.trial.rung); });
  add("point", false, [](const Row& row) { return std::to_string(row.trial.point); });
  add("config", true, [&](const Row& row) { return sweep.configs[row.trial.config].name; });
  add("seed", false, [](const Row& row) { return std::to_string(row.trial.seed); });
  for (std::size_t k = 0; k < sweep.axes.size(); ++k) {
    add(sweep.axes[k].key, true, [&](const Row& row) { return plain(sweep.points[row.trial.point][k]); });
    const std::vector<std::string>& cells = columns.back().cells;
    columns.back().is_text = !std::all_of(cells.begin(), cells.end(), is_number);
  }
  if (!sweep.options.trials.empty()) {
    add("profile", true, [](const Row& row) { return row.trial.profile; });
    add("test", true, [](const Row& row) { return fmt::format("{}", fmt::join(row.trial.test, " ")); });
  }
  add("status", true, [](const Row& row) {
    return std::string(row.result == nullptr ? "missing" : row.result->failed ? "failed" : "done");
  });
  of_result("error", true, [](const TrialResult& result) { return result.error; });
  of_result("guarantee", true, [](const TrialResult& result) { return result.guarantee; });
  add("counts", false, [&](const Row& row) {
    return std::string(row.result != nullptr && counts(sweep.options, *row.result) ? "1" : "0");
  });
  of_result("seconds", false, [](const TrialResult& result) { return number_text(result.seconds); });
  for (const std::string& name : metric_names(rows))
    of_result(name, false, [&](const TrialResult& result) { return number_text(result.metric(name)); });
  add("run", true, [](const Row& row) { return SweepFolder::run_name(row.trial.id); });
  return columns;
}

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_of(const std::vector<Column>& columns) {
  std::string out;
  for (const Column& column : columns) out += (out.empty() ? "" : ",") + csv_text(column.name);
  for (std::size_t row = 0; row < columns.front().cells.size(); ++row) {
    char separator = '\n';
    for (const Column& column : columns) out += std::exchange(separator, ',') + csv_text(column.cells[row]);
  }
  return out + "\n";
}

Vector numbers_of(const std::vector<std::string>& cells) {
  Vector numbers(static_cast<Eigen::Index>(cells.size()));
  std::transform(cells.begin(), cells.end(), numbers.begin(), [](const std::string& cell) {
    return cell.empty() ? std::nan("") : std::strtod(cell.c_str(), nullptr);
  });
  return numbers;
}

}  // namespace

void write_tables(const Sweep& sweep, const SweepFolder& folder, const SweepState& state) {
  const std::vector<Column> columns = columns_of(sweep, state);
  write_atomic_file(folder.file("table.csv"), csv_of(columns), "the table");
  Hdf5Writer file(folder.file("table.h5"));
  std::vector<std::string> names, axes;
  for (const Column& column : columns) {
    names.push_back(column.name);
    const std::string item = "/trials/" + column.name;
    if (column.is_text) {
      file.write(item, column.cells);
    } else {
      file.write(item, numbers_of(column.cells));
    }
  }
  for (const Axis& axis : sweep.axes) {
    axes.push_back(axis.key);
    std::vector<std::string> values = axis.extremes();
    std::transform(values.begin(), values.end(), values.begin(), plain);
    file.write_attribute("/trials/" + axis.key, "values", values);
    file.write_attribute("/trials/" + axis.key, "scale",
                         std::string(!axis.values.empty() ? "list"
                                     : axis.logarithmic   ? "log"
                                                          : "linear"));
  }
  const SweepOptions& options = sweep.options;
  file.write_attribute("/", "name", options.name);
  file.write_attribute("/", "objective", options.objective);
  file.write_attribute("/", "direction", options.direction);
  file.write_attribute("/", "guarantee", options.guarantee);
  file.write_attribute("/", "dtw_limit", options.dtw_limit);
  file.write_attribute("/", "share", options.share);
  if (sweep.is_conformal) file.write_attribute("/", "beta_split_over", sweep.trials());
  file.write_attribute("/", "axes", axes);
  file.write_attribute("/", "columns", names);
  file.commit();
}

}  // namespace s2nnds
