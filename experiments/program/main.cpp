// SPDX-License-Identifier: BSD-3-Clause
// s2nnds: learns a motion from demonstrations and certifies it. See README.md for the commands.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <csignal>

#include "commands.h"
#include "keys_command.h"
#include "log.h"
#include "range_command.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/platform.h"
#include "s2nnds/deployment/export_format.h"
#include "s2nnds/runs/version.h"
#include "scene_commands.h"
#include "studio_command.h"
#include "sweep_command.h"

namespace {

using namespace s2nnds::program;

// The choices and the help of export --format come from the table of formats.
void add_export_format(CLI::App& command, ExportArguments& policy) {
  std::vector<std::string> names, help;
  for (const s2nnds::ExportFormat& format : s2nnds::export_formats()) {
    names.emplace_back(format.name);
    help.push_back(fmt::format("{} ({}, for {})", format.name, format.ending, format.needs));
  }
  policy.format = names.front();
  command.add_option("--format", policy.format, fmt::format("{}", fmt::join(help, ", ")))
      ->capture_default_str()
      ->check(CLI::IsMember(names));
}

void add_range(CLI::App& command, RangeChoice& choice) {
  command
      .add_option("--stretch", choice.stretch,
                  "by what share space may be stretched and squeezed, up to 0.95")
      ->capture_default_str();
  command.add_option(
      "--within", choice.within,
      "in the data's unit: a radius, or half sizes of a box (one a coordinate), that displacements stay in");
}

int run(int argc, char** argv) {
  CLI::App app("Learns robot motions from demonstrations and certifies that they converge and stay safe.",
               "s2nnds");
  app.require_subcommand(1);
  app.set_version_flag("--version", fmt::format("s2nnds {} ({})\n{}", s2nnds::program_version(),
                                                s2nnds::build_type(), s2nnds::library_versions()));
  CommonArguments common;
  common.words = argv;
  int code = kVerified;
  const auto command = [&](const char* name, const char* help) {
    CLI::App* sub = app.add_subcommand(name, help);
    sub->add_option("--data", common.data,
                    "folder of the data files (else $S2NNDS_DATA, else ../shared/data)");
    sub->add_option("--threads", common.threads, "threads of everything that computes; 0: all cores")
        ->check(CLI::Range(0, 4096));
    sub->add_flag("--json", common.json, "print one JSON object as the last line");
    return sub;
  };

  NewArguments fresh;
  CLI::App* sub = command("new", "read recordings, tell what they hold, and write a configuration for them");
  sub->add_option("sources", fresh.sources, "files of one kind, or a folder of them")->required();
  sub->add_option("--out", fresh.out, "configuration to write (TOML); the figure lies beside it")->required();
  sub->add_option("--unit", fresh.unit, "of the positions: m, mm, cm, rad, deg or another text");
  sub->add_option("--time", fresh.time, "column of the times, by name or number from 0");
  sub->add_option("--position", fresh.position, "columns of the positions");
  sub->add_option("--quaternion", fresh.quaternion, "columns of the orientations");
  sub->add_option("--quaternion-order", fresh.quaternion_order, "of the numbers in them")
      ->check(CLI::IsMember({"xyzw", "wxyz"}));
  sub->add_option("--time-unit", fresh.time_unit, "of the times")
      ->check(CLI::IsMember({"s", "ms", "us", "ns"}));
  sub->add_option("--rate", fresh.rate, "samples per second, of files without times")
      ->check(CLI::PositiveNumber);
  sub->callback([&] { code = new_config(fresh, common); });

  PreviewArguments looking;
  sub = command("preview", "draw what a configuration asks for, and name what is wrong with it");
  sub->add_option("config", looking.config, "configuration (TOML)")->required();
  sub->add_option("--set", looking.assignments, "key=value, overrides the configuration");
  sub->add_option("--out", looking.out, "figure to write (default CONFIG-preview.png)");
  sub->callback([&] { code = preview(looking, common); });

  TrainArguments training;
  sub = command("train", "train to a certificate and store the run");
  sub->add_option("config", training.config, "configuration (TOML)");
  sub->add_option("--set", training.assignments, "key=value, overrides the configuration");
  sub->add_option("--seed", training.seed, "overrides the configuration's seed");
  sub->add_option("--out", training.out, "run file to write (default NAME-seedN.h5)");
  sub->add_option("--resume", training.resume, "go on from the last round of this run file");
  sub->add_option(
         "--until", training.until,
         "certified: stop at the first certificate, --resume goes on from it; finished: all of training")
      ->check(CLI::IsMember({"certified", "finished"}))
      ->capture_default_str();
  sub->callback([&] {
    if (training.config.empty() == training.resume.empty()) {
      s2nnds::fail("train: expected either a configuration or --resume RUN.h5");
    }
    code = train(training, common);
  });

  AdaptArguments adapting;
  sub = command("adapt", "make a certified run for a scene that has changed");
  sub->add_option("run", adapting.run, "certified run file")->required();
  sub->add_option("--set", adapting.assignments, "key=value below problem., what has changed")->required();
  sub->add_option("--out", adapting.out, "run file to write (default RUN-adapted.h5)");
  sub->callback([&] { code = adapt(adapting, common); });

  RangeArguments ranging;
  sub = command("range", "say how far an obstacle may be displaced with no new training or proof");
  sub->add_option("run", ranging.run, "certified run file")->required();
  sub->add_option("--obstacle", ranging.choice.obstacle,
                  "which of a union, from 0 in the order of problem.unsafe.of, or all")
      ->capture_default_str();
  add_range(*sub, ranging.choice);
  sub->callback([&] { code = range(ranging, common); });

  VerifyArguments verification;
  sub = command("verify", "check the networks of a stored run");
  sub->add_option("run", verification.run, "run file")->required();
  sub->add_option("--method", verification.method, "sampled, conformal or proof")
      ->check(CLI::IsMember({"sampled", "conformal", "proof"}));
  sub->add_option("--artifact", verification.artifact,
                  "proof: also write the problem, the weights and the boxes that prove it, for s2nnds-check");
  sub->add_option("--samples", verification.samples, "samples a region");
  sub->add_option("--epsilon", verification.epsilon, "conformal: share of a region that may be violated");
  sub->add_option("--beta", verification.beta, "conformal: one minus the confidence");
  sub->add_option("--speed", verification.speed,
                  "auto: with --method proof, also find the speed factors that are certified")
      ->check(CLI::IsMember({"auto"}));
  sub->add_option("--set", verification.assignments,
                  "execution.key=value: how the robot executes the motion, instead of what the run says");
  sub->callback([&] { code = verify(verification, common); });

  EvaluateArguments evaluation;
  sub = command("evaluate", "measure errors and safe areas of a stored run");
  sub->add_option("run", evaluation.run, "run file")->required();
  sub->add_option("--splits", evaluation.splits,
                  "train, test, validation: also the errors of each demonstration of these")
      ->check(CLI::IsMember({"train", "test", "validation"}));
  sub->callback([&] { code = evaluate(evaluation, common); });

  ExportArguments policy;
  sub = command("export", "write the policy of a stored run");
  sub->add_option("run", policy.run, "run file")->required();
  add_export_format(*sub, policy);
  sub->add_option("--precision", policy.precision, "header: what f is computed in, float or double")
      ->check(CLI::IsMember({"float", "double"}));
  sub->add_option("--range", policy.range.obstacle,
                  "header: also the motion for displacements of this obstacle, a number from 0 or all");
  add_range(*sub, policy.range);
  sub->add_option("--out", policy.out, "file to write (default: the run's name with the format's ending)");
  sub->callback([&] { code = export_policy(policy, common); });

  PlotArguments figures;
  sub = command("plot", "draw the figures of a stored run");
  sub->add_option("run", figures.run, "run file")->required();
  sub->add_option("--out", figures.out, "folder for the figures (default RUN-figures)");
  sub->callback([&] { code = plot(figures); });

  StudioArguments drawing;
  sub = command("studio", "draw a motion in the browser and watch it become safe, or look at a run");
  sub->add_option("run", drawing.run, "run file to look at");
  sub->add_option("--folder", drawing.folder, "where drawing, runs and exports lie")->capture_default_str();
  sub->add_option("--port", drawing.port, "of 127.0.0.1 (default: any that is free)")
      ->check(CLI::Range(1, 65535));
  sub->callback([&] { code = open_studio(drawing, common); });

  ReportArguments page;
  sub = command("report", "write a run as one HTML file that opens from disk");
  sub->add_option("run", page.run, "run file")->required();
  sub->add_option("--out", page.out, "file to write (default RUN.html)");
  sub->callback([&] { code = report(page, common); });

  // Its own options are those of the Python module that does it, which also tells its help.
  sub = app.add_subcommand("import",
                           "turn ROS bags, MCAP files or LeRobot data sets into demonstrations (HDF5)");
  sub->set_help_flag("");
  sub->prefix_command();
  sub->callback([&app, &code] { code = import_recordings(app.get_subcommand("import")->remaining()); });

  SweepArguments sweeping;
  sub = command("sweep",
                "train many runs: axes of values, on all cores or on a cluster; the same command goes on");
  sub->add_option("sweep", sweeping.sweep, "what to sweep (TOML)")->required();
  sub->add_option("--out", sweeping.out, "folder of the sweep (default NAME-sweep)");
  sub->add_option("--jobs", sweeping.jobs, "trials at once (default: as many as there are cores for)")
      ->check(CLI::PositiveNumber);
  sub->add_flag("--dry-run", sweeping.dry_run, "list the trials, start none");
  sub->add_flag("--report", sweeping.report, "rank what there is so far and draw it, start nothing");
  sub->add_flag("--retry-failed", sweeping.retry_failed, "run failed trials again");
  sub->add_option(
      "--slurm", sweeping.slurm,
      "submit to Slurm: partition=,time=,account=,qos=,mem= as sbatch takes them; throttle=N tasks at "
      "once; chunk=N trials a task");
  sub->add_option("--trial", sweeping.trial, "run this one trial here");
  sub->add_option("--only", sweeping.only,
                  "FIRST-LAST: the part of the list that a task of a job array runs");
  sub->add_option("--rung", sweeping.rung, "which list --only counts in")->check(CLI::NonNegativeNumber);
  sub->add_option("--program", sweeping.program,
                  "what to start for each trial (for tests; default: this program)");
  sub->callback([&] { code = sweep(sweeping, common); });

  InfoArguments told;
  sub = command("info", "say what a run file holds");
  sub->add_option("run", told.run, "run file")->required();
  sub->add_flag("--all", told.all, "also conditions, configuration, the last rounds, hashes, versions");
  sub->callback([&] { code = info(told, common); });

  app.add_subcommand("keys", "list every key of a configuration (JSON)")->callback([&] { code = keys(); });

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);
  } catch (const CLI::RequiredError& e) {
    // Without a command, CLI11 tells neither what was found instead nor what there is.
    const bool other_word = app.get_subcommands().empty() && argc > 1;
    s2nnds::fail("{}{}", other_word ? fmt::format("unknown command {}: ", argv[1]) : "", e.what());
  } catch (const CLI::ParseError& e) {
    spdlog::error("s2nnds: {}", e.what());
    return kBadInput;
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  s2nnds::keep_freed_memory();  // training allocates and frees the same few megabytes every step
  start_log();
  std::signal(SIGXFSZ, SIG_IGN);  // a full disk is then an error of the write, which is reported
  try {
    return run(argc, argv);
  } catch (const s2nnds::Error& e) {
    spdlog::error("s2nnds: {}", e.what());
    return kBadInput;
  } catch (const std::exception& e) {
    spdlog::error("s2nnds: internal failure: {}", e.what());
    return kInternalFailure;
  }
}
