// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drawing.h"
#include "s2nnds/core/child_process.h"

namespace s2nnds::studio {

// Something that the page asks for cannot be done now, as the message says.
class Conflict : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// All that a studio knows, whatever the page does: the drawing, the run, the program that works on it, and the folder
// that holds them. Every method may be called from any thread.
class Studio {
 public:
  // Takes the folder, which is made where it is not there, and goes on with the drawing and the run in it.
  // `program` is the path of s2nnds. Throws Error when another studio has the folder.
  Studio(std::string folder, std::string program);
  ~Studio();  // stops what runs
  Studio(const Studio&) = delete;
  Studio& operator=(const Studio&) = delete;

  // Takes a copy of a run file and shows it. Throws Error as load_certified_run does.
  void open_run(const std::string& path);
  // A file that was dropped on the page: a run file is opened, of demonstrations a drawing is made and returned.
  // Throws Error when it can be read as neither.
  nlohmann::ordered_json take_file(const std::string& name, const std::string& bytes);

  void set_drawing(const nlohmann::json& json);  // throws Error as drawing_from does
  // What is impossible or unwise in the drawing, in words, and the sets in numbers; before any training.
  nlohmann::ordered_json preview();

  // Each starts the program, and throws Conflict when something runs already or there is nothing to begin with.
  void learn();   // of the drawing, until the first certificate
  void resume();  // trains the run on, to the end
  void adapt();   // the run to the drawing's obstacles
  void cancel();  // what runs; nothing where nothing does

  // Drawing, what runs or ran last, and the numbers of the versions of drawing and run.
  nlohmann::ordered_json state();
  // The run as the page has it (run_json) with its version; "null" without one.
  std::string run();
  // Waits until the state's number is another than `seen`, for at most `seconds`; false when the studio closes.
  bool wait_for_change(std::int64_t& seen, double seconds);
  void close();  // ends all waiting, stops what runs

  // What can be downloaded of the run. Throws Conflict without one, Error when it cannot be made.
  struct Download {
    std::string name, bytes;
  };
  Download download(const std::string& kind);

 private:
  struct Job {
    std::string kind;               // learn, resume, adapt
    std::string state = "running";  // running, done, failed, cancelled
    std::string message;            // of a failure
    std::deque<std::string> lines;  // the last ones that it said
    double seconds = 0;             // that it took; while it runs, since it started
    int exit_code = 0;
    double certified = 0;  // seconds until its proof was over; 0: not yet
  };

  std::string path(const std::string& name) const;
  std::string next_run_path();
  void start(const std::string& kind, std::vector<std::string> words, const std::string& run_path);
  void work(const std::vector<std::string>& words, const std::string& run_path);
  bool show(const std::string& run_path, bool final);  // whether it could be read
  void join();
  void changed();  // with mutex_ held
  void keep_state();

  const std::string folder_, program_;
  int lock_ = -1;
  std::mutex mutex_;
  std::condition_variable change_;
  std::int64_t version_ = 1, run_version_ = 0, drawing_version_ = 0, run_number_ = 0;
  bool look_only_ = false;                     // the drawing does not say all of the run's sets
  nlohmann::ordered_json adapting_ = nullptr;  // the obstacles that the run under way is adapted to
  bool closing_ = false, cancelled_ = false, run_final_ = false;
  Drawing drawing_;
  nlohmann::ordered_json learned_ = nullptr;  // the drawing that the run was made of
  std::string run_path_, run_text_ = "null";
  std::optional<Job> job_;
  double began_ = 0;
  RunningChild* child_ = nullptr;  // of the thread worker_, while it runs
  std::mutex starting_;            // one thread at a time starts or joins the worker
  std::thread worker_;
};

}  // namespace s2nnds::studio
