// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/slurm.h"

#include <algorithm>
#include <cstdio>
#include <set>
#include <sstream>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr std::int64_t most_tasks = 1000;

std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string command_line(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    // $first and $last are the script's own.
    line += (line.empty() ? "" : " ") + (word.starts_with("$") ? "\"" + word + "\"" : quoted(word));
  }
  return line;
}

struct Output {
  int status;
  std::string text;
};

Output run(const std::vector<std::string>& words) {
  FILE* pipe = ::popen((command_line(words) + " 2>&1").c_str(), "r");
  check(pipe != nullptr, "{}: cannot start it", words.front());
  Output output;
  char buffer[4096];
  while (const std::size_t count = std::fread(buffer, 1, sizeof(buffer), pipe))
    output.text.append(buffer, count);
  output.status = ::pclose(pipe);
  std::replace(output.text.begin(), output.text.end(), '\n', ' ');
  while (output.text.ends_with(' ')) output.text.pop_back();
  return output;
}

std::int64_t parse_count(const std::string& name, const std::string& value) {
  const bool digits =
      !value.empty() && value.size() < 10 &&
      std::all_of(value.begin(), value.end(), [](unsigned char c) { return std::isdigit(c); });
  check(digits && std::stol(value) >= 1, "--slurm: {}: expected an integer >= 1, found \"{}\"", name, value);
  return std::stol(value);
}

// What all of the sweep's jobs have, and of `names` what is set.
std::string directives(const Sweep& sweep, const SlurmOptions& options, const std::string& log,
                       const std::set<std::string>& names) {
  std::string text = fmt::format("#!/bin/bash\n#SBATCH --job-name={}\n#SBATCH --output={}\n",
                                 quoted(sweep.options.name), quoted(log));
  for (const auto& [name, value] : options.sbatch) {
    if (names.contains(name)) text += fmt::format("#SBATCH --{}={}\n", name, value);
  }
  return text + "#SBATCH --open-mode=append\n";
}

const std::set<std::string> kOfJobs = {"partition", "account", "qos"};
const std::set<std::string> kOfTasks = {"partition", "account", "qos", "time", "mem"};

}  // namespace

SlurmOptions parse_slurm(const std::string& text) {
  SlurmOptions options;
  std::istringstream entries(text);
  for (std::string entry; std::getline(entries, entry, ',');) {
    const auto equals = entry.find('=');
    const std::string name = entry.substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : entry.substr(equals + 1);
    check(!value.empty() && value.find_first_of(" \t\n'\"") == std::string::npos,
          "--slurm: expected name=value without spaces, found \"{}\"", entry);
    if (kOfTasks.contains(name)) {
      options.sbatch[name] = value;
    } else if (name == "throttle") {
      options.throttle = parse_count(name, value);
    } else if (name == "chunk") {
      options.chunk = parse_count(name, value);
    } else {
      fail("--slurm: unknown name {}; expected partition, time, account, qos, mem, throttle or chunk", name);
    }
  }
  return options;
}

std::int64_t chunk_of(const SlurmOptions& options, std::int64_t trials) {
  return options.chunk > 0 ? options.chunk : (trials + most_tasks - 1) / most_tasks;
}

std::string array_text(const std::vector<std::int64_t>& positions, std::int64_t chunk) {
  std::string text;
  std::int64_t first = -1;
  std::int64_t last = -1;
  const auto put = [&] {
    if (first < 0) return;
    text += text.empty() ? "" : ",";
    text += first == last ? fmt::format("{}", first) : fmt::format("{}-{}", first, last);
  };
  for (const std::int64_t position : positions) {
    const std::int64_t task = position / chunk;
    if (task == last) continue;
    if (task != last + 1 || first < 0) {
      put();
      first = task;
    }
    last = task;
  }
  put();
  return text;
}

std::string batch_script(const Sweep& sweep, const SweepFolder& folder, const SlurmOptions& options,
                         const std::string& array, std::int64_t chunk, std::int64_t threads,
                         const std::vector<std::string>& command) {
  std::string text = directives(sweep, options, folder.file("slurm/%A_%a.log"), kOfTasks);
  text += fmt::format("#SBATCH --array={}{}\n", array,
                      options.throttle > 0 ? fmt::format("%{}", options.throttle) : std::string());
  text += fmt::format("#SBATCH --ntasks=1\n#SBATCH --cpus-per-task={}\n", threads);
  text += "#SBATCH --requeue\n";           // when a node fails
  text += "#SBATCH --signal=B:TERM@30\n";  // before the time is over: the trials' last rounds are on the disk
  text += fmt::format("first=$((SLURM_ARRAY_TASK_ID * {0}))\nlast=$((first + {1}))\n", chunk, chunk - 1);
  text += "echo \"$(date -Is) $(hostname): task $SLURM_ARRAY_TASK_ID, start ${SLURM_RESTART_COUNT:-0}\"\n";
  return text + "exec " + command_line(command) + "\n";
}

std::string follow_up_script(const Sweep& sweep, const SweepFolder& folder, const SlurmOptions& options,
                             const std::vector<std::string>& command) {
  return directives(sweep, options, folder.file("slurm/%j.log"), kOfJobs) + "#SBATCH --time=01:00:00\n" +
         "exec " + command_line(command) + "\n";
}

std::string submit(const std::string& script, const std::vector<std::string>& words) {
  std::vector<std::string> command = {"sbatch", "--parsable"};
  command.insert(command.end(), words.begin(), words.end());
  command.push_back(script);
  const Output output = run(command);
  check(output.status == 0, "sbatch: {}", output.text);
  return output.text.substr(0, output.text.find(';'));
}

std::vector<std::string> active_jobs(const std::vector<std::string>& jobs) {
  std::vector<std::string> active;
  for (const std::string& job : jobs) {
    const Output output = run({"squeue", "--noheader", "--jobs=" + job});
    if (output.status == 0 && !output.text.empty())
      active.push_back(job);  // an error: Slurm has forgotten the job
  }
  return active;
}

}  // namespace s2nnds
