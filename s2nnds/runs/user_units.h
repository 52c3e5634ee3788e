// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "s2nnds/runs/run_record.h"

namespace s2nnds {

// The normalised numbers of a run as its user reads them: in the data's unit and frame, and where the problem is
// written in normalised coordinates in these as well. Keeps a reference to the record.
class UserUnits {
 public:
  explicit UserUnits(const RunRecord& record) : record_(record) {}  // see above

  bool in_data() const {
    return record_.problem.frame == "data";
  }                          // the problem is written in the data's frame
  std::string name() const;  // of the unit of length: "mm"; "units of the data" when unknown

  std::string length(double normalised) const;  // "20 mm", "20 mm (0.05 normalised)"
  std::string speed(double normalised) const;   // "20 mm/s", "20 mm/s (0.05 normalised)"
  std::string volume(double normalised) const;  // of states: "20 mm^2", "0.05 normalised (20 mm^2)"
  std::string area(
      double normalised) const;  // the same of places, which have one dimension less with a phase
  // "(520, 200) mm", "(0.05, 0), which is (20, 0) mm from the goal"
  std::string position(const std::vector<double>& normalised) const;
  // "(0, -300) mm to (1000, 700) mm", rounded inwards; "(-1.25, -1.25) to (1.25, 1.25)"
  std::string workspace() const;

 private:
  std::string power(double normalised, Eigen::Index n) const;

  const RunRecord& record_;
};

}  // namespace s2nnds
