#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "s2nnds/sweeps/ranking.h"

namespace s2nnds::program {

// What a sweep on this machine says on stderr. A terminal gets one line that is drawn anew, a pipe one plain
// line a trial.
class SweepProgress {
 public:
  // `before`: the results that are there already; `missing`: trials to run.
  SweepProgress(const Sweep& sweep, const std::vector<TrialResult>& before, std::size_t missing, int jobs);

  void ended(const TrialResult& result);
  void note(const std::string& line);  // something that is worth a line of its own
  void draw(std::size_t running);      // terminals: time goes on
  void finish();

 private:
  void take(const TrialResult& result);
  std::string best_text() const;
  std::string left_text() const;
  void clear();

  const Sweep& sweep_;
  bool terminal_;
  int jobs_;
  std::size_t total_;
  std::size_t ended_ = 0;
  std::size_t ended_here_ = 0;
  std::size_t failed_ = 0;
  std::optional<TrialResult> best_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

}  // namespace s2nnds::program
