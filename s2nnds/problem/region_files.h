// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace s2nnds {

// The files that regions are made from, whole, by the names that a configuration gives them. A run keeps
// them, so that what it proved can be checked where the files are not, or have changed.
class RegionFiles {
 public:
  // Files below `folder`, each read when it is first asked for. Absolute names are taken as they are.
  explicit RegionFiles(const std::string& folder = "") : folder_(folder) {}
  // Those of a run and no others: bytes by name.
  explicit RegionFiles(std::map<std::string, std::string> stored) : bytes_(std::move(stored)) {}

  // The bytes of one file. Throws Error when it cannot be read, is empty, or is not among those of the run.
  const std::string& bytes(const std::string& name);
  // All that were asked for, or that the run has.
  const std::map<std::string, std::string>& all() const { return bytes_; }
  // Names of those that are also below `folder`, with other bytes there.
  std::vector<std::string> changed_in(const std::string& folder) const;

 private:
  std::optional<std::string> folder_;
  std::map<std::string, std::string> bytes_;
};

}  // namespace s2nnds
