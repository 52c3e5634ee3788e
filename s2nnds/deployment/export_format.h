// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "s2nnds/deployment/cpp_header.h"
#include "s2nnds/deployment/policy.h"
#include "s2nnds/runs/scene_range.h"

namespace s2nnds {

// What the formats let one choose.
struct ExportOptions {
  HeaderPrecision precision = HeaderPrecision::float32;  // of f in a C++ header alone
  std::optional<SceneRange> range = std::nullopt;        // whose displaced scenes a C++ header has as well
};

// One way to write a policy. A new one is a row in export_format.cpp and a function that makes its bytes.
struct ExportFormat {
  std::string_view name;    // as --format takes it
  std::string_view ending;  // of its files
  std::string_view title;   // in messages
  std::string_view needs;   // to use the file
  bool turns = false;       // whether it can hold a policy of poses
  bool libtorch = false;    // whether LibTorch writes it: without (runs/libtorch.h), `contents` throws Error
  // The file's bytes, of a policy that check_policy() holds for; `path` is where they will lie.
  std::string (*contents)(const Policy& policy, const ExportOptions& options, const std::string& path);
};

// Every format; the first one is the program's default.
const std::vector<ExportFormat>& export_formats();

// Throws Error on an unknown name.
const ExportFormat& export_format_from(std::string_view name);

// Checks the policy and writes it beside `path`, then renames. Throws Error if check_policy() does, if the
// format cannot hold the policy, or if the file cannot be written.
void export_policy(const Policy& policy, const ExportFormat& format, const ExportOptions& options,
                   const std::string& path);

}  // namespace s2nnds
