// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/deployment/export_format.h"

#include <fmt/ranges.h>

#include "s2nnds/core/atomic_file.h"
#include "s2nnds/core/check.h"
#include "s2nnds/deployment/onnx.h"
#include "s2nnds/deployment/pt2.h"
#include "s2nnds/deployment/torchscript.h"

namespace s2nnds {

const std::vector<ExportFormat>& export_formats() {
  static const std::vector<ExportFormat> formats = {
      {"header", ".h", "C++ header", "a C++17 compiler", true, false,
       [](const Policy& policy, const ExportOptions& options, const std::string& path) {
         return cpp_header(policy, options.precision, policy_namespace(path), options.range);
       }},
      {"onnx", ".onnx", "ONNX model", "an ONNX runtime", true, false,
       [](const Policy& policy, const ExportOptions&, const std::string&) { return onnx_model(policy); }},
      {"pt2", ".pt2", "torch.export program",
       "PyTorch 2.6 or newer; the Python of S2NNDS_PYTHON writes it with that", false, false,
       [](const Policy& policy, const ExportOptions&, const std::string&) { return pt2_program(policy); }},
      {"torchscript", ".pt", "TorchScript module", "PyTorch and LibTorch; deprecated by PyTorch", false, true,
       [](const Policy& policy, const ExportOptions&, const std::string&) {
         return torchscript_module(policy);
       }},
  };
  return formats;
}

const ExportFormat& export_format_from(std::string_view name) {
  std::vector<std::string_view> names;
  for (const ExportFormat& format : export_formats()) {
    if (format.name == name) return format;
    names.push_back(format.name);
  }
  fail("format: found \"{}\", expected one of {}", name, fmt::join(names, ", "));
}

void export_policy(const Policy& policy, const ExportFormat& format, const ExportOptions& options,
                   const std::string& path) {
  check_policy(policy);
  check(format.turns || !policy.orientation,
        "format: found {} and a policy of poses, expected header or onnx", format.name);
  check(!options.range || format.name == "header", "format: found {} and a range of scenes, expected header",
        format.name);
  write_atomic_file(path, format.contents(policy, options, path), "the policy");
}

}  // namespace s2nnds
