#include "s2nnds/sweeps/result_table.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>

#include "s2nnds/runs/hdf5_file.h"

namespace s2nnds {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

// A row of the table before its columns are known.
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

template <typename Value>
TableColumn numbers(const std::string& name, const std::vector<Row>& rows, Value value) {
  TableColumn column{name, false, {}, {}};
  for (const Row& row : rows) column.numbers.push_back(static_cast<double>(value(row)));
  return column;
}

template <typename Value>
TableColumn texts(const std::string& name, const std::vector<Row>& rows, Value value) {
  TableColumn column{name, true, {}, {}};
  for (const Row& row : rows) column.texts.push_back(value(row));
  return column;
}

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

// An axis of numbers becomes a column of numbers.
TableColumn axis_column(const Sweep& sweep, std::size_t axis, const std::vector<Row>& rows) {
  TableColumn column = texts(sweep.axes[axis].key, rows,
                             [&](const Row& row) { return plain(sweep.points[row.trial.point][axis]); });
  for (const std::string& text : column.texts) {
    if (!is_number(text)) return column;
  }
  column.is_text = false;
  for (const std::string& text : column.texts) column.numbers.push_back(std::strtod(text.c_str(), nullptr));
  column.texts.clear();
  return column;
}

// In the order in which they first appear.
std::vector<std::string> metric_names(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  std::map<std::string, bool> seen;
  for (const Row& row : rows) {
    if (row.result == nullptr) continue;
    for (const auto& [name, value] : row.result->metrics) {
      if (!seen[name]) names.push_back(name);
      seen[name] = true;
    }
  }
  return names;
}

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_cell(const TableColumn& column, std::size_t row) {
  if (column.is_text) return csv_text(column.texts[row]);
  return std::isnan(column.numbers[row]) ? "" : fmt::format("{}", column.numbers[row]);
}

std::size_t row_count(const TableColumn& column) {
  return column.is_text ? column.texts.size() : column.numbers.size();
}

void write_effects(Hdf5Writer& file, const EffectTable& effects) {
  const auto write = [&](const std::string& name, const auto& of_row) {
    std::vector<std::string> texts;
    for (const AxisEffect& row : effects.rows) texts.push_back(of_row(row));
    file.write("/effects/" + name, texts);
  };
  write("axis", [](const AxisEffect& row) { return row.axis; });
  write("from", [](const AxisEffect& row) { return row.from; });
  write("to", [](const AxisEffect& row) { return row.to; });
  std::vector<std::string> figures;
  for (std::size_t k = 0; k < effects.figures.size(); ++k) {
    const EffectFigure& figure = effects.figures[k];
    if (!figure.told) continue;
    figures.push_back(figure.name);
    Vector change(effects.rows.size()), error(effects.rows.size());
    for (std::size_t i = 0; i < effects.rows.size(); ++i) {
      change[static_cast<Eigen::Index>(i)] = effects.rows[i].on[k].change;
      error[static_cast<Eigen::Index>(i)] = effects.rows[i].on[k].error;
    }
    const std::string item = "/effects/" + figure.name;
    file.write(item, change);
    file.write(item + "_error", error);
    file.write_attribute(item, "trials", figure.trials);
    file.write_attribute(item, "kind", std::string(figure.factor ? "factor" : "difference"));
  }
  file.write_attribute("/effects", "figures", figures);
}

}  // namespace

ResultTable make_table(const Sweep& sweep, const SweepState& state) {
  const std::vector<Row> rows = rows_of(sweep, state);
  ResultTable table;
  auto& columns = table.columns;
  columns.push_back(numbers("trial", rows, [](const Row& row) { return row.trial.id; }));
  columns.push_back(numbers("rung", rows, [](const Row& row) { return row.trial.rung; }));
  columns.push_back(numbers("point", rows, [](const Row& row) { return row.trial.point; }));
  columns.push_back(
      texts("config", rows, [&](const Row& row) { return sweep.configs[row.trial.config].name; }));
  columns.push_back(
      numbers("seed", rows, [&](const Row& row) { return sweep.options.seeds[row.trial.seed]; }));
  for (std::size_t axis = 0; axis < sweep.axes.size(); ++axis) {
    columns.push_back(axis_column(sweep, axis, rows));
    table.axes.push_back(sweep.axes[axis].key);
  }
  columns.push_back(texts("status", rows, [](const Row& row) {
    return std::string(row.result == nullptr ? "missing" : row.result->failed ? "failed" : "done");
  }));
  columns.push_back(
      texts("error", rows, [](const Row& row) { return row.result == nullptr ? "" : row.result->error; }));
  columns.push_back(texts("guarantee", rows,
                          [](const Row& row) { return row.result == nullptr ? "" : row.result->guarantee; }));
  columns.push_back(numbers("counts", rows, [&](const Row& row) {
    return row.result != nullptr && counts(sweep.options, *row.result) ? 1.0 : 0.0;
  }));
  columns.push_back(numbers(
      "seconds", rows, [](const Row& row) { return row.result == nullptr ? nothing : row.result->seconds; }));
  for (const std::string& name : metric_names(rows)) {
    columns.push_back(numbers(name, rows, [&](const Row& row) {
      return row.result == nullptr ? nothing : row.result->metric(name);
    }));
  }
  columns.push_back(texts("run", rows, [](const Row& row) { return SweepFolder::run_name(row.trial.id); }));
  return table;
}

std::string to_csv(const ResultTable& table) {
  std::string out;
  for (const TableColumn& column : table.columns) out += (out.empty() ? "" : ",") + csv_text(column.name);
  out += '\n';
  const std::size_t rows = row_count(table.columns.front());
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      out += (k > 0 ? "," : "") + csv_cell(table.columns[k], row);
    }
    out += '\n';
  }
  return out;
}

void write_table(const std::string& path, const ResultTable& table, const EffectTable& effects,
                 const SweepOptions& options) {
  Hdf5Writer file(path);
  std::vector<std::string> names;
  for (const TableColumn& column : table.columns) names.push_back(column.name);
  file.write_attribute("/", "name", options.name);
  file.write_attribute("/", "objective", options.objective);
  file.write_attribute("/", "direction", options.direction);
  file.write_attribute("/", "guarantee", options.guarantee);
  file.write_attribute("/", "dtw_limit", options.dtw_limit);
  file.write_attribute("/", "share", options.share);
  file.write_attribute("/", "axes", table.axes);
  file.write_attribute("/", "columns", names);
  for (const TableColumn& column : table.columns) {
    const std::string item = "/trials/" + column.name;
    if (column.is_text) {
      file.write(item, column.texts);
    } else {
      file.write(item, Vector(Eigen::Map<const Vector>(column.numbers.data(),
                                                       static_cast<Eigen::Index>(column.numbers.size()))));
    }
  }
  write_effects(file, effects);
  file.commit();
}

}  // namespace s2nnds
