// SPDX-License-Identifier: BSD-3-Clause
#include "run_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

#include "s2nnds/runs/statement.h"
#include "s2nnds/runs/threads.h"
#include "s2nnds/runs/user_units.h"

namespace s2nnds::program {
namespace {

constexpr std::size_t kWidth = 100;      // columns of text
constexpr Eigen::Index kLastRounds = 6;  // of the history, shown by details()

std::string number(double value) { return std::isnan(value) ? "-" : fmt::format("{:.4g}", value); }

// Rows of cells: the first column to the left, the others to the right.
using Rows = std::vector<std::vector<std::string>>;
std::string aligned(const Rows& rows) {
  std::vector<std::size_t> widths;
  for (const auto& cells : rows) {
    widths.resize(std::max(widths.size(), cells.size()));
    for (std::size_t k = 0; k < cells.size(); ++k) widths[k] = std::max(widths[k], cells[k].size());
  }
  std::string text;
  for (const auto& cells : rows) {
    text += fmt::format("  {:<{}}", cells[0], widths[0]);
    for (std::size_t k = 1; k < cells.size(); ++k) text += fmt::format("  {:>{}}", cells[k], widths[k]);
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n";
  }
  return text;
}

std::string scales(const RunRecord& record) {
  const std::string unit = UserUnits(record).name();
  return fmt::format("1 normalised = {} {} (length), {} {}/s (velocity)",
                     number(record.data.frame.position_scale), unit, number(record.data.frame.velocity_scale),
                     unit);
}

// How far each demonstration ends from the goal; what is only rounding is 0.
Vector end_distances(const RunData& data) {
  const Vector found = data.frame.end_distances(data.demonstrations);
  return (found.array() < 1e-6 * data.frame.position_scale).select(0.0, found);
}

// "0.2 mm", "0.1 to 0.3 mm"
std::string range_of(const Vector& lengths, const std::string& unit) {
  const std::string low = number(lengths.minCoeff()), high = number(lengths.maxCoeff());
  return low == high ? fmt::format("{} {}", low, unit) : fmt::format("{} to {} {}", low, high, unit);
}

std::string goal(const RunRecord& record) {
  const Frame& frame = record.data.frame;
  return fmt::format("{}{}; demonstrations end {} from it{}", frame.position_text(frame.goal),
                     frame.name.empty() ? "" : " in " + frame.name,
                     range_of(end_distances(record.data), UserUnits(record).name()),
                     frame.moves_demonstrations() ? ", each was moved to end there" : "");
}

// The words of a set as the configuration wrote it, with their unit.
std::string set(const std::string& words, const RunRecord& record) {
  if (words == "none") return words;
  const UserUnits units(record);
  return fmt::format("{} ({})", words, units.in_data() ? units.name() : "normalised");
}

Rows error_rows(const RunRecord& record) {
  const EvaluationSummary& e = record.evaluation;
  const auto in_unit = [](double value, double scale) { return number(value * scale); };
  const double velocity = record.data.frame.velocity_scale;
  const double position = record.data.frame.position_scale;
  const UserUnits units(record);
  Rows rows = {{"errors", "train", "test"},
               {fmt::format("velocity, RMS [{}/s]", units.name()), in_unit(std::sqrt(e.mse_train), velocity),
                in_unit(std::sqrt(e.mse_test), velocity)},
               {fmt::format("motion, DTW [{}]", units.name()), in_unit(e.dtw_train, position),
                in_unit(e.dtw_test, position)}};
  if (record.orientation) {
    rows.push_back(
        {"orientation, mean [degrees]", number(e.orientation_mean_train), number(e.orientation_mean_test)});
    rows.push_back({"orientation, largest [degrees]", number(e.orientation_largest_train),
                    number(e.orientation_largest_test)});
  }
  if (units.in_data()) return rows;
  rows.push_back({"velocity, MSE (normalised)", number(e.mse_train), number(e.mse_test)});
  rows.push_back({"motion, DTW (normalised)", number(e.dtw_train), number(e.dtw_test)});
  return rows;
}

std::string safe_area(const RunRecord& record) {
  const EvaluationSummary& e = record.evaluation;
  if (std::isnan(e.safe_area)) return "not measured";
  return fmt::format("{}, {:.1f} % of what is truly safe", UserUnits(record).area(e.safe_area),
                     100.0 * e.safe_area_ratio);
}

std::string disturbance(const RunRecord& record) {
  const Certificate& c = record.certificate;
  if (!(c.disturbance_margin > 0.0)) return "not certified";
  return fmt::format("|w| <= {}; float32 {}", UserUnits(record).speed(c.disturbance_margin),
                     c.float32_error < c.disturbance_margin ? "is covered" : "is NOT covered");
}

std::string speeds(const RunRecord& record) {
  const ExecutionCertificate& c = record.certificate.execution;
  if (std::isinf(c.most_speed))
    return fmt::format("from {:.4g} times the demonstrated one on", c.least_speed);
  return fmt::format("{:.4g} to {:.4g} times the demonstrated one, up to {}", c.least_speed, c.most_speed,
                     UserUnits(record).speed(c.most_speed_command));
}

// What is certified of the motion as a robot executes it, where that was asked for.
std::string executed(const RunRecord& record) {
  const ExecutionCertificate& c = record.certificate.execution;
  const UserUnits units(record);
  std::string text;
  if (c.invariant) {
    const bool arrives = c.convergence_radius < record.problem.workspace.half_widths().minCoeff();
    text =
        row("as executed",
            "stays in the safe set; " +
                (arrives ? "comes within " + units.length(c.convergence_radius) + " of the goal"
                         : std::string("that it comes near the goal was not shown"))) +
        row("shield", c.shielded ? "for velocities up to " + units.speed(c.most_command) : "not certified");
    if (c.most_speed > 0.0) text += row("speed", speeds(record));
  } else if (!c.model.empty()) {
    text = row("as executed", "NOT certified") + (c.reason.empty() ? "" : paragraph(c.reason));
  }
  if (c.damping > 0.0)
    text += row("push", fmt::format("<= {:.4g} N s, at every sample of the demonstrations", c.least_push));
  return text;
}

std::string time(const RunRecord& record) {
  const RunTiming& t = record.timing;
  std::string text;
  for (const auto& [name, seconds] :
       {std::pair{"training", t.training}, std::pair{"proof", t.proof}, std::pair{"as executed", t.execution},
        std::pair{"evaluation", t.evaluation}})
    if (!std::isnan(seconds)) text += fmt::format("{} {:.1f} s, ", name, seconds);
  if (!record.checkpoint) return text + "no rounds";
  return text + fmt::format("{} rounds{}", record.checkpoint->round,
                            record.checkpoint->finished ? "" : ", not finished: train --resume goes on");
}

Rows sample_rows(Method method, const Certificate& certificate) {
  Rows rows = {{std::string(to_string(method)), "verdict", "samples", "violations", "worst"}};
  if (method == Method::conformal)
    rows[0].insert(rows[0].end(), {"p", "l", "epsilon", "beta", "tightest epsilon"});
  for (const ConditionVerdict& v : certificate.conditions) {
    if (v.method != method) continue;
    rows.push_back({std::string(to_string(v.condition)), std::string(to_string(v.verdict)),
                    std::to_string(v.samples), std::to_string(v.violations), number(v.worst)});
    if (method == Method::conformal)
      rows.back().insert(rows.back().end(), {number(v.quantile), std::to_string(v.order), number(v.epsilon),
                                             number(v.beta), number(v.tightest_epsilon)});
  }
  return rows;
}

Rows proof_rows(const RunRecord& record) {
  const Certificate& certificate = record.certificate;
  const UserUnits units(record);
  Rows rows = {{"proof", "verdict", "boxes", "open", "open volume", "violated at"}};
  for (const ConditionVerdict& v : certificate.conditions) {
    if (v.method != Method::proof) continue;
    rows.push_back({std::string(to_string(v.condition)), std::string(to_string(v.verdict)),
                    std::to_string(v.boxes), std::to_string(v.open_boxes),
                    v.open_volume > 0.0 ? units.volume(v.open_volume) : "0",
                    v.witness.empty() ? "" : units.position(v.witness)});
  }
  if (rows.size() == 1) return rows;
  for (const auto& [name, value] : flatten(certificate.side))
    rows.push_back({name, value == "true" ? "proved" : "undecided"});
  return rows;
}

// One column a round, the last ones.
Rows history_rows(const RunRecord& record) {
  Rows rows;
  for (const auto& [name, column] : record.history) {
    rows.push_back({name});
    const Eigen::Index shown = std::min(kLastRounds, column.size());
    for (const double value : column.tail(shown)) rows.back().push_back(number(value));
  }
  return rows;
}

// What is guaranteed of it.
std::string orientation(const RunRecord& record) {
  const std::string text = orientation_sentence(record);
  return text.empty() ? "" : paragraph(text);
}

// The same of all motions, from anywhere.
std::string stability(const RunRecord& record) {
  const std::string text = stability_sentence(record);
  return text.empty() ? "" : paragraph(text);
}

std::string remarks(const RunRecord& record) {
  std::string text;
  for (const std::string& remark : record.remarks) text += paragraph(remark);
  return text;
}

}  // namespace

std::string paragraph(const std::string& text) {
  std::string all, line;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!line.empty() && line.size() + word.size() + 3 > kWidth) {
      all += "  " + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return all + "  " + line + "\n";
}

std::string row(const char* name, const std::string& text) {
  const std::size_t room = kWidth - 18;
  return fmt::format("  {:<14}  {}\n", name, text.size() > room ? text.substr(0, room - 3) + "..." : text);
}

std::string first_screen(const RunRecord& record, const std::string& path) {
  std::string guarantee(to_string(record.certificate.guarantee));
  for (char& letter : guarantee) letter = static_cast<char>(std::toupper(letter));
  const RunData& data = record.data;
  return fmt::format("{} (seed {}): guarantee {}{}\n", record.name, record.seed, guarantee,
                     record.certificate.stability.proved ? ", stability PROVED" : "") +
         stability(record) + paragraph(guarantee_sentence(record)) + orientation(record) + remarks(record) +
         "\n" +
         row("data", fmt::format("{} demonstrations in {} dimensions: {} train, {} test, {} validation",
                                 data.demonstrations.size(), data.dimension, data.split.train.size(),
                                 data.split.test.size(), data.split.validation.size())) +
         row("goal", goal(record)) + row("workspace", UserUnits(record).workspace()) +
         row("unsafe set", set(record.problem.unsafe, record)) +
         row("initial set", set(record.problem.initial, record)) + "\n" + aligned(error_rows(record)) + "\n" +
         row("safe area", safe_area(record)) + row("disturbance", disturbance(record)) + executed(record) +
         row("time", time(record)) + row("run file", path);
}

std::string condition_tables(const RunRecord& record) {
  std::string text;
  for (const Rows& rows : {sample_rows(Method::sampled, record.certificate),
                           sample_rows(Method::conformal, record.certificate), proof_rows(record)})
    if (rows.size() > 1)
      text += aligned(rows) +
              (rows[0][0] == to_string(Method::conformal) ? paragraph(std::string(kAttemptsCounted)) : "") +
              "\n";
  return text;
}

std::string frame_line(const RunRecord& record) {
  const Frame& frame = record.data.frame;
  std::vector<std::string> ends;
  for (const double distance : end_distances(record.data)) ends.push_back(number(distance));
  return fmt::format("goal {}{}; demonstrations end {} {} from it{}; {}", frame.position_text(frame.goal),
                     frame.name.empty() ? "" : " in " + frame.name, fmt::join(ends, ", "),
                     UserUnits(record).name(),
                     frame.moves_demonstrations() ? ", and each is moved to end there" : "", scales(record));
}

std::string details(const RunRecord& record) {
  std::string values;
  for (const auto& [key, value] : record.config.values) values += fmt::format("  {:<44}  {}\n", key, value);
  const ThreadCounts threads = thread_counts();
  std::string reading = record.data.report.empty() ? "" : "reading\n";
  for (const std::string& line : record.data.report) reading += fmt::format("  {}\n", line);
  return reading + "statement\n" + paragraph(record.certificate.statement) + "\nconditions\n" +
         condition_tables(record) + "configuration\n" + values + "\nlast rounds\n" +
         aligned(history_rows(record)) + "\n" + row("scales", scales(record)) +
         row("weights", fmt::format("SHA-256 {}", weight_hash(record.networks))) +
         row("written", fmt::format("{} by version {}, schema {}", record.created, record.program_version,
                                    run_schema_version)) +
         row("libraries", record.library_versions) +
         row("threads here", fmt::format("loops {}, ATen {}, BLAS {}", threads.loops,
                                         threads.aten ? std::to_string(*threads.aten) : "not loaded",
                                         threads.blas ? std::to_string(*threads.blas) : "without its own"));
}

}  // namespace s2nnds::program
