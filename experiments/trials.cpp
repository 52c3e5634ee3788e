#include "trials.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "program/python_script.h"
#include "program/writable.h"
#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/evaluation/robustness.h"
#include "s2nnds/runs/config.h"
#include "s2nnds/runs/prepared_run.h"
#include "s2nnds/runs/summary.h"
#include "s2nnds/runs/version.h"
#include "s2nnds/sweeps/process_pool.h"

namespace s2nnds::experiment {
namespace {

namespace fs = std::filesystem;

const fs::path kConfigs = fs::path(S2NNDS_EXPERIMENTS) / "configs";

fs::path program() { return fs::read_symlink("/proc/self/exe").parent_path() / "s2nnds"; }

std::vector<std::string> assignments_of(const Trial& trial, const Arguments& arguments) {
  std::vector<std::string> all = trial.assignments;
  all.insert(all.end(), arguments.assignments.begin(), arguments.assignments.end());
  all.push_back(fmt::format("seed={}", trial.seed));
  return all;
}

enum class State { absent, begun, finished };

// Of the trial's run file. Throws Error when something else is there, which a run would replace.
State state_of(const std::string& run, const std::string& resolved) {
  if (!fs::exists(run)) return State::absent;
  const RunRecord record = [&] {
    try {
      return load_run(run);
    } catch (const Error& error) {
      fail("{}; it is not replaced, expected another --out or no such file there", error.what());
    }
  }();
  check(record.config.resolved == resolved,
        "{}: found a run of another configuration, expected another --out or no such file there", run);
  if (!record.checkpoint || !record.checkpoint->finished) return State::begun;
  return std::isnan(record.evaluation.mse_train) ? State::begun : State::finished;
}

std::vector<std::string> command_of(const Trial& trial, const Arguments& arguments, const std::string& run,
                                    bool resume, int threads) {
  std::vector<std::string> command = {program(),      "train",     "--data",
                                      arguments.data, "--threads", std::to_string(threads)};
  if (resume) {
    command.insert(command.end(), {"--resume", run});
    return command;
  }
  command.insert(command.end(), {kConfigs / trial.config, "--out", run});
  for (const std::string& assignment : assignments_of(trial, arguments))
    command.insert(command.end(), {"--set", assignment});
  return command;
}

std::string last_line(const std::string& path) {
  std::ifstream file(path);
  std::string line, last;
  while (std::getline(file, line)) {
    if (!line.empty()) last = line;
  }
  return last;
}

const char* outcome(const Trial& trial, int exit_code) {
  if (exit_code == 0) return "certified";
  return trial.name.ends_with("-uncertified") ? "trained without conditions" : "NOT certified";
}

TrialResult read(const Trial& trial, const std::string& run) {
  TrialResult result{trial, run, load_run(run), {}};
  result.summary = nlohmann::json::parse(summary_json(result.record, run));
  result.summary.erase("threads");  // of this process, not of the run's
  return result;
}

}  // namespace

std::vector<TrialResult> run_trials(const std::vector<Trial>& trials, const Arguments& arguments) {
  const int cores = available_cores(), jobs = arguments.jobs > 0 ? arguments.jobs : cores;
  const int threads = std::max(1, cores / jobs);
  std::vector<std::string> runs;
  std::vector<PoolJob> waiting;
  for (std::size_t k = 0; k < trials.size(); ++k) {
    const Trial& trial = trials[k];
    const std::string base = fs::path(arguments.out) / trial.name, path = kConfigs / trial.config;
    runs.push_back(base + ".h5");
    const Config config = parse_config(read_config_text(path, assignments_of(trial, arguments)), path);
    const State state = state_of(runs.back(), to_toml(config));
    if (state == State::finished) continue;
    waiting.push_back({static_cast<std::int64_t>(k),
                       command_of(trial, arguments, runs.back(), state == State::begun, threads),
                       base + ".log"});
  }
  fs::create_directories(arguments.out);
  ProcessPool pool({{"OMP_WAIT_POLICY", "passive"}, {"OMP_NUM_THREADS", std::to_string(threads)}});
  std::size_t begun = 0, ended = 0;
  while (ended < waiting.size()) {
    while (begun < waiting.size() && pool.running() < static_cast<std::size_t>(jobs)) {
      fs::remove(waiting[begun].log);
      pool.start(waiting[begun++]);
    }
    const auto end = pool.wait(1.0);
    check(!pool.interrupted(), "interrupted after {} of {} runs; the same command goes on", ended,
          waiting.size());
    if (!end) continue;
    const Trial& trial = trials[static_cast<std::size_t>(end->id)];
    const std::string log = fs::path(arguments.out) / (trial.name + ".log");
    check(end->signal == 0 && (end->exit_code == 0 || end->exit_code == 3), "{}: {} ({})", trial.name,
          last_line(log),
          end->signal == 0 ? fmt::format("exit code {}", end->exit_code)
                           : fmt::format("signal {}", end->signal));
    fmt::print(stderr, "[{}/{}] {}: {} after {:.0f} s\n", ++ended, waiting.size(), trial.name,
               outcome(trial, end->exit_code), end->seconds);
  }
  std::vector<TrialResult> results;
  for (std::size_t k = 0; k < trials.size(); ++k) results.push_back(read(trials[k], runs[k]));
  return results;
}

namespace {

// Runs one of the Python scripts that draw.
void run_plot(const std::string& script, const std::vector<std::string>& words) {
  const int code = program::run_python("figures", std::string(S2NNDS_NOTEBOOKS) + "/" + script, words);
  check(code == 0, "{}: exit code {}", script, code);
}

}  // namespace

bool is_drawn(const Trial& trial, const Arguments& arguments) {
  return trial.name.ends_with(fmt::format("-seed{}", arguments.seeds.front()));
}

void draw_all(const std::vector<TrialResult>& results, const Arguments& arguments) {
  for (const TrialResult& result : results) {
    if (!is_drawn(result.trial, arguments)) continue;
    const fs::path folder = fs::path(arguments.out) / "figures" / result.trial.name;
    fs::create_directories(folder);
    run_plot("plot_run.py", {result.run, "--out", folder});
  }
}

void draw_together(const std::string& name, const std::string& kind, const std::vector<TrialResult>& results,
                   const Arguments& arguments, const nlohmann::json& found) {
  const fs::path figures = fs::path(arguments.out) / "figures";
  fs::create_directories(figures);
  std::vector<std::string> words = {kind, figures / (name + ".png")};
  if (!found.is_null()) {
    words.push_back(fs::path(arguments.out) / (name + ".json"));
    write_atomic_file(words.back(), found.dump(), "what the figure shows");
  }
  for (const TrialResult& result : results) {
    if (is_drawn(result.trial, arguments)) words.push_back(result.run);
  }
  run_plot("plot_paper.py", words);
}

std::vector<Trial> seed_trials(const std::string& name, const std::string& config, const Arguments& arguments,
                               const std::vector<std::string>& assignments) {
  std::vector<Trial> trials;
  for (const int seed : arguments.seeds)
    trials.push_back({fmt::format("{}-seed{}", name, seed), config, assignments, seed});
  std::vector<std::string> without = uncertified();
  without.insert(without.end(), assignments.begin(), assignments.end());
  const int first = arguments.seeds.front();
  trials.push_back({fmt::format("{}-seed{}-uncertified", name, first), config, without, first});
  return trials;
}

std::vector<Trial> split_trials(const std::string& name, const std::string& config,
                                const Arguments& arguments) {
  std::vector<Trial> trials;
  for (const auto& [a, b] :
       {std::pair(0, 1), std::pair(2, 3), std::pair(4, 5), std::pair(6, 0), std::pair(1, 5)}) {
    trials.push_back({fmt::format("{}-test{}{}", name, a, b),
                      config,
                      {fmt::format("data.test=[{}, {}]", a, b), "training.enlarge_rounds=0"}});
    if (arguments.quick) break;
  }
  return trials;
}

std::vector<std::string> uncertified() {
  return {"training.loss.lyapunov=0",
          "training.loss.barrier_sets=0",
          "training.loss.barrier_decrease=0",
          "training.loss.rollout_safety=0",
          "training.loss.obstacle_normal=0",
          "training.rollout_points=0",
          "training.rounds=5",
          "training.min_rounds=5",
          "training.refine_rounds=0",
          "training.imitation_finetune_rounds=0",
          "training.enlarge_rounds=0",
          "training.samples=1000",
          "verification.method=\"sampled\""};
}

namespace {

void check_seeds(const Arguments& arguments) {
  check(!arguments.seeds.empty(), "--seeds: found none, expected one or more");
  std::vector<int> sorted = arguments.seeds;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  check(twice == sorted.end(), "--seeds: found {} twice, expected each seed once",
        twice == sorted.end() ? 0 : *twice);
  for (const std::string& assignment : arguments.assignments) {
    const std::string key = assignment.substr(0, assignment.find_first_of("= "));
    check(key != "seed", "--set {}: expected --seeds, which all runs of a driver have", assignment);
  }
}

// Fills in what the command line left open and finds out what is wrong with it before hours of training.
void prepare(Arguments& arguments, const std::string& name) {
  check_seeds(arguments);
  check(!arguments.out.empty(), "--out: found nothing, expected a folder");
  const bool standard =
      !arguments.quick && arguments.assignments.empty() && arguments.seeds == Arguments{}.seeds;
  arguments.data = data_directory(arguments.data);
  if (arguments.quick) arguments.seeds.resize(1);
  if (arguments.results.empty() && !standard) {
    arguments.results = fs::path(arguments.out) / (name + ".json");  // a folder that is yet to be made
    return;
  }
  if (arguments.results.empty()) {
    const fs::path folder = fs::path(S2NNDS_EXPERIMENTS) / "results";
    fs::create_directories(folder);
    arguments.results = folder / (name + ".json");
  }
  program::check_writable(arguments.results);
}

}  // namespace

int run_driver(int argc, char** argv, const std::string& name, const std::string& about,
               const std::function<Report(const Arguments&)>& body) {
  using nlohmann::json;
  CLI::App app(about, name);
  Arguments arguments;
  arguments.out = "runs/" + name;
  bool no_figures = false;
  app.add_option("--data", arguments.data,
                 "folder of the data files (else $S2NNDS_DATA, else ../shared/data)");
  app.add_option("--out", arguments.out, "folder for run files and figures")->capture_default_str();
  app.add_option("--results", arguments.results,
                 "results file (default: experiments/results/" + name +
                     ".json; with --quick, --set or --seeds in --out)");
  app.add_option("--set", arguments.assignments, "key=value, overrides every run's configuration");
  app.add_option("--seeds", arguments.seeds, "seeds of every problem")->capture_default_str();
  app.add_option("--jobs", arguments.jobs, "runs at a time; 0: one a core")->check(CLI::Range(0, 4096));
  app.add_flag("--quick", arguments.quick, "one seed and one split of every problem");
  app.add_flag("--no-figures", no_figures, "draw nothing");
  try {
    app.parse(argc, argv);
    arguments.figures = !no_figures;
    prepare(arguments, name);
    json results = {{"experiment", name},           {"program_version", program_version()},
                    {"created", time_stamp()},      {"seeds", arguments.seeds},
                    {"set", arguments.assignments}, {"quick", arguments.quick}};
    const Report report = body(arguments);
    results.update(report.results);
    write_atomic_file(arguments.results, results.dump(1) + "\n", "the results");
    fmt::print(stderr, "results: {}\n", arguments.results);
    if (arguments.figures) report.draw();
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return 2;
  } catch (const Error& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return 2;
  } catch (const fs::filesystem_error& error) {
    fmt::print(stderr, "{}: {}: {}, expected a folder that can be written\n", name, error.path1().string(),
               error.code().message());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: internal failure: {}\n", name, error.what());
    return 1;
  }
  return 0;
}

std::string Table::text() const {
  const auto line = [](const std::vector<std::string>& cells) {
    std::string text = "|";
    for (const std::string& cell : cells) text += " " + cell + " |";
    return text + "\n";
  };
  std::string text = line(head_) + "|";
  for (std::size_t k = 0; k < head_.size(); ++k) text += "---|";
  text += "\n";
  for (const auto& row : rows_) text += line(row);
  return text;
}

nlohmann::json Table::json() const { return {{"head", head_}, {"rows", rows_}}; }

double proof_boxes(const nlohmann::json& summary) {
  double boxes = 0.0;
  for (const nlohmann::json& condition : summary["conditions"])
    if (condition.contains("proof")) boxes += condition["proof"]["boxes"].get<double>();
  return boxes;
}

Table table_of_runs(const std::vector<TrialResult>& results) {
  Table table({"run", "guarantee", "rounds", "train s", "proof s", "boxes", "train MSE", "test MSE",
               "test SD", "test DTW", "safe area", "of true", "margin"});
  for (const TrialResult& result : results) {
    const nlohmann::json& s = result.summary;
    const auto cell = [&](const char* key, const char* form) {
      return s[key].is_null() ? std::string("-") : fmt::format(fmt::runtime(form), s[key].get<double>());
    };
    // Without a guarantee {B <= 0} is no safe set.
    const auto guaranteed = [&](const char* key, const char* form) {
      return s["guarantee"] == "none" ? std::string("-") : cell(key, form);
    };
    const double boxes = proof_boxes(s);
    table.add(
        {result.trial.name, s["guarantee"], cell("rounds", "{:.0f}"),
         fmt::format("{:.0f}", s["seconds"]["training"].get<double>()),
         s["seconds"].contains("proof") ? fmt::format("{:.2f}", s["seconds"]["proof"].get<double>()) : "-",
         boxes > 0.0 ? fmt::format("{:.0f}", boxes) : "-", cell("mse_train", "{:.4f}"),
         cell("mse_test", "{:.4f}"), cell("sd_test", "{:.3f}"), cell("dtw_test", "{:.4f}"),
         guaranteed("safe_area", "{:.2f}"), guaranteed("safe_area_ratio", "{:.3f}"),
         guaranteed("disturbance_margin", "{:.2g}")});
  }
  return table;
}

Table table_of_robustness(const std::vector<TrialResult>& results, const Arguments& arguments) {
  Table table({"run", "starts", "motions", "arrive", "without certificate", "in {B <= 0}", "of these arrive",
               "safe", "without", "closest to Xu", "without", "time to goal", "without"});
  for (const TrialResult& certified : results) {
    const auto free = std::find_if(results.begin(), results.end(), [&](const TrialResult& other) {
      return other.trial.name == certified.trial.name + "-uncertified";
    });
    if (free == results.end() || certified.trial.name.find("-test") != std::string::npos) continue;
    const PreparedRun setup = prepare(certified.record, arguments.data);
    const Networks& networks = certified.record.networks;
    const bool guaranteed = certified.record.certificate.guarantee != Guarantee::none;
    const auto ours = measure_robustness(networks.f, guaranteed ? &networks.B : nullptr, setup.problem,
                                         setup.demonstrations, 0);
    const auto theirs =
        measure_robustness(free->record.networks.f, nullptr, setup.problem, setup.demonstrations, 0);
    for (std::size_t k = 0; k < ours.size(); ++k) {
      const auto cell = [](double value, int digits = 3) {
        return std::isnan(value) ? std::string("-") : fmt::format("{:.{}f}", value, digits);
      };
      table.add({certified.trial.name, ours[k].starts, std::to_string(ours[k].motions),
                 cell(ours[k].converged), cell(theirs[k].converged),
                 guaranteed ? std::to_string(ours[k].covered) : "-", cell(ours[k].covered_converged),
                 cell(ours[k].safe), cell(theirs[k].safe), cell(ours[k].closest), cell(theirs[k].closest),
                 cell(ours[k].time_to_goal, 2), cell(theirs[k].time_to_goal, 2)});
    }
  }
  return table;
}

Report report_runs(const std::vector<TrialResult>& results, const Arguments& arguments) {
  const Table table = table_of_runs(results), robustness = table_of_robustness(results, arguments);
  fmt::print("{}\n{}", table.text(), robustness.text());
  return {{{"tables", {{"runs", table.json()}, {"robustness", robustness.json()}}},
           {"runs", summaries_of(results)}},
          [=] { draw_all(results, arguments); }};
}

nlohmann::json summaries_of(const std::vector<TrialResult>& results) {
  nlohmann::json runs = nlohmann::json::array();
  for (const TrialResult& result : results) {
    runs.push_back(result.summary);
    runs.back()["trial"] = result.trial.name;
  }
  return runs;
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return std::nan("");
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace s2nnds::experiment
