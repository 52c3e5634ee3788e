// SPDX-License-Identifier: BSD-3-Clause
#include "studio.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "page_files.h"
#include "run_json.h"
#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/runs/certified_scope.h"
#include "s2nnds/runs/scene.h"

namespace s2nnds::studio {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kMostLines = 200;
constexpr double kRunPause = 0.25;  // seconds between two looks at a run in training
constexpr double kRoom = 0.25;      // around dropped demonstrations, as a share of their extent

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  check(file.good(), "{}: cannot read it", path);
  return bytes.str();
}

// Two studios in one folder would write over each other's files.
int locked(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder + "/preview", error);
  const int file = ::open((folder + "/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  check(file >= 0, "{}: cannot write into it: {}", folder, std::strerror(errno));
  const bool taken = ::flock(file, LOCK_EX | LOCK_NB) != 0;
  if (taken) ::close(file);
  check(!taken, "{}: another studio is open in this folder; expected none (--folder names another)", folder);
  return file;
}

// The last line that says why, without the program's name.
std::string reason(const std::string& errors, int exit_code) {
  std::string line, last;
  std::istringstream lines(errors);
  while (std::getline(lines, line))
    if (!line.empty()) last = line;
  if (last.starts_with("s2nnds: ")) return last.substr(8);
  if (exit_code > 128) return fmt::format("signal {} ended the program", exit_code - 128);
  return fmt::format("the program ended with exit code {}", exit_code);
}

std::string safe_ending(const std::string& name) {
  const std::string ending = fs::path(name).extension().string();
  for (const char* known : {".csv", ".txt", ".tsv", ".dat", ".npy", ".npz", ".h5", ".hdf5", ".mat"})
    if (ending == known) return ending;
  fail("found a file that does not end in .csv, .txt, .tsv, .dat, .npy, .npz, .h5, .hdf5 or .mat");
}

DemonstrationSet read_dropped(const std::string& file, const std::string& ending, const std::string& folder) {
  DataOptions options;
  options.files = {file};
  options.source = ending == ".npy" || ending == ".npz"   ? "npy"
                   : ending == ".h5" || ending == ".hdf5" ? "hdf5"
                                                          : "csv";
  if (ending == ".mat") {
    options.file = file;
    options.source = "lasa";
    try {
      return read_demonstrations(options, folder);
    } catch (const Error&) {
      options.source = "ds_opt";
    }
  }
  return read_demonstrations(options, folder);
}

// Demonstrations of a file as a drawing, with room around them.
Drawing drawing_of(const DemonstrationSet& set, Drawing before) {
  check(set.dimension() == 2, "found demonstrations in {} dimensions, expected 2", set.dimension());
  Eigen::RowVector2d lower(INFINITY, INFINITY), upper = -lower;
  for (const Demonstration& d : set.demonstrations) {
    lower = lower.cwiseMin(d.position.colwise().minCoeff());
    upper = upper.cwiseMax(d.position.colwise().maxCoeff());
  }
  const double room = kRoom * (upper - lower).maxCoeff();
  before.field = {lower[0] - room, lower[1] - room, upper[0] + room, upper[1] + room};
  before.unit = set.unit.size() <= 8 ? set.unit : "";
  before.strokes = set.demonstrations;
  for (Demonstration& stroke : before.strokes) stroke.time.array() -= stroke.time[0];
  before.obstacles.clear();
  before.initial = {.type = "auto"};
  return before;
}

// The drawing that a run in the plane was made of, as far as it can be drawn.
Drawing drawing_of(const RunRecord& record, Drawing before) {
  const Config config = parse_config(record.config.resolved, "the run's configuration");
  const Frame& frame = record.data.frame;
  const Vector lower = frame.to_data(record.problem.workspace.lower);
  const Vector upper = frame.to_data(record.problem.workspace.upper);
  before.name = "motion";
  if (!record.name.empty() && record.name.size() <= 60 &&
      record.name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
          std::string::npos)
    before.name = record.name;
  before.unit = frame.unit;
  before.seed = record.seed;
  before.field = {lower[0], lower[1], upper[0], upper[1]};
  before.strokes = record.data.demonstrations;
  for (Demonstration& stroke : before.strokes) stroke.time.array() -= stroke.time[0];
  before.obstacles.clear();
  before.initial = {.type = "auto"};
  if (config.problem.frame != "data") return before;
  const RegionOptions& unsafe = config.problem.unsafe;
  if (!obstacles_json(unsafe).is_null() && unsafe.type != "none")
    before.obstacles = unsafe.type == "union" ? unsafe.of : std::vector<RegionOptions>{unsafe};
  if (!shape_json(config.problem.initial).is_null()) before.initial = config.problem.initial;
  return before;
}

constexpr const char* kLookOnly =
    "this run has sets that cannot be drawn here, so it can only be looked at; Clear begins a new drawing, "
    "and "
    "s2nnds adapt works on it from the command line";

// Whether the drawing made of it says all of its sets.
bool can_be_drawn(const RunRecord& record) {
  if (record.data.dimension != 2) return false;
  const ProblemOptions problem = parse_config(record.config.resolved, "the run's configuration").problem;
  return problem.frame == "data" && !obstacles_json(problem.unsafe).is_null() &&
         (problem.initial.type == "auto" || !shape_json(problem.initial).is_null());
}

}  // namespace

Studio::Studio(std::string folder, std::string program)
    : folder_(std::move(folder)), program_(std::move(program)), lock_(locked(folder_)) {
  while (fs::exists(path(fmt::format("run-{}.h5", run_number_ + 1)))) ++run_number_;
  if (!fs::exists(path("studio.json"))) return;
  try {
    const nlohmann::json kept = nlohmann::json::parse(read(path("studio.json")));
    drawing_ = drawing_from(kept.at("drawing"));
    learned_ = kept.at("learned");
    look_only_ = kept.at("look_only").get<bool>();
    const std::string run = kept.at("run").get<std::string>();
    if (!run.empty() && fs::path(run).filename() == run) show(path(run), true);
  } catch (const std::exception& error) {
    ::close(lock_);
    fail("{}: cannot go on from it: {}; move it away to begin anew", path("studio.json"),
         std::string(error.what()).substr(0, 200));
  }
}

Studio::~Studio() {
  close();
  join();
  ::close(lock_);
}

std::string Studio::path(const std::string& name) const { return folder_ + "/" + name; }

std::string Studio::next_run_path() { return path(fmt::format("run-{}.h5", ++run_number_)); }

void Studio::changed() {
  ++version_;
  change_.notify_all();
}

void Studio::keep_state() {
  const ordered_json kept = {{"drawing", to_json(drawing_)},
                             {"learned", learned_},
                             {"look_only", look_only_},
                             {"run", run_path_.empty() ? "" : fs::path(run_path_).filename().string()}};
  write_atomic_file(path("studio.json"), kept.dump(), "the studio's state");
}

// ---- runs

bool Studio::show(const std::string& run_path, bool final) {
  ordered_json json;
  try {
    json = run_json(load_certified_run(run_path));
  } catch (const Error&) {
    if (final) throw;
    return false;  // not written yet
  }
  const std::lock_guard lock(mutex_);
  if (!adapting_.is_null() && run_path_ != run_path) learned_["obstacles"] = adapting_;
  json["number"] = ++run_version_;
  json["final"] = final;
  run_path_ = run_path;
  run_final_ = final;
  run_text_ = json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  changed();
  return true;
}

void Studio::open_run(const std::string& from) {
  const RunRecord record = load_certified_run(from);
  const std::lock_guard starting(starting_);
  {
    const std::lock_guard lock(mutex_);
    if (job_ && job_->state == "running") throw Conflict("a motion is being learned; cancel it first");
  }
  std::string to;
  {
    const std::lock_guard lock(mutex_);
    to = next_run_path();
  }
  write_atomic_file(to, read(from), "the run");
  show(to, true);
  const std::lock_guard lock(mutex_);
  look_only_ = !can_be_drawn(record);
  if (record.data.dimension == 2) {
    drawing_ = drawing_of(record, drawing_);
    ++drawing_version_;
  }
  learned_ = to_json(drawing_);
  job_.reset();
  keep_state();
  changed();
}

ordered_json Studio::take_file(const std::string& name, const std::string& bytes) {
  const std::string ending = safe_ending(name), file = "dropped" + ending;
  write_atomic_file(path(file), bytes, "the file");
  std::string no_run;
  if (ending == ".h5") {
    try {
      load_certified_run(path(file));
    } catch (const Error& error) {
      no_run = error.what();
    }
    if (no_run.empty()) {
      open_run(path(file));
      return {{"opened", "run"}};
    }
  }
  Drawing drawing;
  {
    const std::lock_guard lock(mutex_);
    drawing = drawing_;
  }
  DemonstrationSet set;
  try {
    set = read_dropped(file, ending, folder_);
  } catch (const Error& error) {
    fail("{}", no_run.empty() ? error.what() : no_run + "; and as demonstrations: " + error.what());
  }
  const ordered_json json = to_json(drawing_of(set, drawing));
  drawing_from(nlohmann::json(json));  // within the limits
  return {{"opened", "demonstrations"}, {"drawing", json}, {"report", set.report}};
}

// ---- the drawing

void Studio::set_drawing(const nlohmann::json& json) {
  Drawing drawing = drawing_from(json);
  const std::lock_guard lock(mutex_);
  drawing_ = std::move(drawing);
  if (!learned_.is_null() && to_json(drawing_)["strokes"] != learned_["strokes"]) look_only_ = false;
  ++drawing_version_;
  keep_state();
}

ordered_json Studio::preview() {
  Drawing drawing;
  {
    const std::lock_guard lock(mutex_);
    drawing = drawing_;
  }
  ordered_json json = {{"refusals", ordered_json::array()}, {"warnings", ordered_json::array()}};
  if (drawing.strokes.empty()) return json;
  write_atomic_file(path("preview/demonstrations.csv"), demonstrations_csv(drawing), "the demonstrations");
  try {
    const Scene scene = look_at(parse_config(configuration(drawing), "drawing"), path("preview"));
    json["refusals"] = scene.refusals;
    json["warnings"] = scene.warnings;
    json["report"] = scene.data.report;
    json["clearances"] = ordered_json::array();
    if (!scene.frame) return json;
    for (const std::string& text : clearance_texts(scene.clearances, *scene.frame))
      json["clearances"].push_back(text);
    json["goal"] = std::vector<double>(scene.frame->goal.begin(), scene.frame->goal.end());
    json["moved"] = scene.frame->moves_demonstrations();
    if (scene.problem) json["initial"] = shape_json(scene.problem->written_initial);
  } catch (const Error& error) {
    json["refusals"].push_back(error.what());
  }
  return json;
}

// ---- what runs

void Studio::learn() {
  Drawing drawing;
  std::string run;
  {
    const std::lock_guard lock(mutex_);
    drawing = drawing_;
  }
  if (drawing.strokes.empty()) throw Conflict("there is no demonstration yet");
  const std::lock_guard starting(starting_);
  {
    const std::lock_guard lock(mutex_);
    if (job_ && job_->state == "running") throw Conflict("a motion is being learned; cancel it first");
    run = next_run_path();
    if (look_only_) throw Conflict(kLookOnly);
    learned_ = to_json(drawing);
    adapting_ = nullptr;
    run_path_.clear();
    run_text_ = "null";
    ++run_version_;
    keep_state();
  }
  write_atomic_file(path("demonstrations.csv"), demonstrations_csv(drawing), "the demonstrations");
  write_atomic_file(path("motion.toml"), configuration(drawing), "the configuration");
  start("learn",
        {program_, "train", path("motion.toml"), "--data", folder_, "--out", run, "--until", "certified",
         "--json"},
        run);
}

void Studio::resume() {
  const std::lock_guard starting(starting_);
  std::string run;
  {
    const std::lock_guard lock(mutex_);
    if (job_ && job_->state == "running") throw Conflict("a motion is being learned; cancel it first");
    if (run_path_.empty()) throw Conflict("there is no run yet");
    run = next_run_path();
  }
  start("resume", {program_, "train", "--resume", run_path_, "--out", run, "--json"}, run);
}

void Studio::adapt() {
  const std::lock_guard starting(starting_);
  std::string run, unsafe;
  {
    const std::lock_guard lock(mutex_);
    if (job_ && job_->state == "running") throw Conflict("a motion is being learned; cancel it first");
    if (run_path_.empty()) throw Conflict("there is no run yet");
    run = next_run_path();
    unsafe = unsafe_toml(drawing_);
    if (look_only_) throw Conflict(kLookOnly);
    adapting_ = to_json(drawing_)["obstacles"];
  }
  start("adapt", {program_, "adapt", run_path_, "--set", "problem.unsafe=" + unsafe, "--out", run, "--json"},
        run);
}

// With starting_ held.
void Studio::start(const std::string& kind, std::vector<std::string> words, const std::string& run_path) {
  if (worker_.joinable()) worker_.join();  // it has ended, or ends at once
  {
    const std::lock_guard lock(mutex_);
    if (closing_) throw Conflict("the studio is closing");
    job_.emplace().kind = kind;
    cancelled_ = false;
    began_ = now();
    changed();
  }
  worker_ = std::thread([this, words = std::move(words), run_path] { work(words, run_path); });
}

// The thread of one child: it starts it, listens to it and waits for its end.
void Studio::work(const std::vector<std::string>& words, const std::string& run_path) {
  std::string failure, shown_failure;
  int exit_code = 0;
  try {
    RunningChild child(words);
    {
      const std::lock_guard lock(mutex_);
      child_ = &child;
      if (cancelled_ || closing_) child.stop();
    }
    double last = 0;
    ChildResult result;
    try {
      result = child.wait([&](const std::string& line) {
        const bool certified = line.starts_with("guarantee=");
        const bool round = line.starts_with("round=") || line.starts_with("warm start");
        {
          const std::lock_guard lock(mutex_);
          job_->lines.push_back(line.substr(0, 400));
          if (job_->lines.size() > kMostLines) job_->lines.pop_front();
          changed();
        }
        if (certified || (round && now() - last >= kRunPause)) {
          show(run_path, false);
          last = now();
        }
        if (!certified) return;
        const std::lock_guard lock(mutex_);
        job_->certified = now() - began_;
        changed();
      });
    } catch (...) {
      const std::lock_guard lock(mutex_);
      child_ = nullptr;
      throw;
    }
    {
      const std::lock_guard lock(mutex_);
      child_ = nullptr;
    }
    exit_code = result.exit_code;
    if (exit_code != 0 && exit_code != 3) failure = reason(result.errors, exit_code);
    if (fs::exists(run_path)) show(run_path, failure.empty());
  } catch (const std::exception& error) {
    failure = error.what();
  }
  const std::lock_guard lock(mutex_);
  job_->seconds = now() - began_;
  job_->exit_code = exit_code;
  job_->state = cancelled_ ? "cancelled" : failure.empty() ? "done" : "failed";
  job_->message = cancelled_ ? "" : failure;
  try {
    keep_state();
  } catch (const Error& error) {
    job_->message += error.what();
  }
  changed();
}

void Studio::cancel() {
  const std::lock_guard lock(mutex_);
  if (!job_ || job_->state != "running") return;
  cancelled_ = true;
  if (child_ != nullptr) child_->stop();
}

void Studio::join() {
  const std::lock_guard starting(starting_);
  if (worker_.joinable()) worker_.join();
}

void Studio::close() {
  const std::lock_guard lock(mutex_);
  closing_ = true;
  if (child_ != nullptr) child_->stop();
  changed();
}

// ---- what the page is told

ordered_json Studio::state() {
  const std::lock_guard lock(mutex_);
  ordered_json json = {{"version", version_},
                       {"run_version", run_version_},
                       {"drawing_version", drawing_version_},
                       {"has_run", !run_path_.empty()},
                       {"drawing", to_json(drawing_)},
                       {"learned", learned_},
                       {"look_only", look_only_},
                       {"folder", folder_},
                       {"job", nullptr}};
  if (!job_) return json;
  const double seconds = job_->state == "running" ? now() - began_ : job_->seconds;
  json["job"] = {{"kind", job_->kind},          {"state", job_->state}, {"message", job_->message},
                 {"lines", job_->lines},        {"seconds", seconds},   {"exit_code", job_->exit_code},
                 {"certified", job_->certified}};
  return json;
}

std::string Studio::run() {
  const std::lock_guard lock(mutex_);
  return run_text_;
}

bool Studio::wait_for_change(std::int64_t& seen, double seconds) {
  std::unique_lock lock(mutex_);
  change_.wait_for(lock, std::chrono::duration<double>(seconds),
                   [&] { return closing_ || version_ != seen; });
  seen = version_;
  return !closing_;
}

// ---- downloads

Studio::Download Studio::download(const std::string& kind) {
  std::string run, text;
  {
    const std::lock_guard lock(mutex_);
    if (run_path_.empty()) throw Conflict("there is no run yet");
    run = run_path_;
    text = run_text_;
  }
  const RunRecord record = load_certified_run(run);
  const std::string name =
      record.name.empty() || record.name.find('/') != std::string::npos ? "motion" : record.name;
  if (kind == "run") return {name + ".h5", read(run)};
  if (kind == "configuration") return {name + ".toml", record.config.text};
  if (kind == "report") return {name + ".html", report_page(page_files(), name, text)};
  if (kind == "demonstrations") {
    check(record.data.dimension == 2, "found demonstrations in {} dimensions, expected 2",
          record.data.dimension);
    Drawing drawing;
    drawing.strokes = record.data.demonstrations;
    return {"demonstrations.csv", demonstrations_csv(drawing)};
  }
  const std::vector<std::pair<std::string, std::string>> formats = {
      {"header", ".h"}, {"onnx", ".onnx"}, {"torchscript", ".pt"}};
  for (const auto& [format, ending] : formats) {
    if (format != kind) continue;
    const std::string out = path(name + ending);
    const ChildResult made = run_child({program_, "export", run, "--format", format, "--out", out}, "");
    check(made.exit_code == 0, "{}", reason(made.errors, made.exit_code));
    return {name + ending, read(out)};
  }
  fail(
      "found no download of this name; expected run, configuration, demonstrations, report, header, onnx, "
      "torchscript");
}

}  // namespace s2nnds::studio
