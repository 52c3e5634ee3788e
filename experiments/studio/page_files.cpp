// SPDX-License-Identifier: BSD-3-Clause
#include "page_files.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "s2nnds/core/check.h"
#include "s2nnds/core/python_module.h"

namespace s2nnds::studio {
namespace {

namespace fs = std::filesystem;

// Scripts of the report, in an order in which each comes after those that it imports.
constexpr const char* kReportScripts[] = {"networks.js",  "shapes.js",  "contours.js",
                                          "portrait.js",  "space.js",   "motion.js",
                                          "statement.js", "history.js", "report.js"};

const std::map<std::string, std::string>& types() {
  static const std::map<std::string, std::string> all = {{".html", "text/html; charset=utf-8"},
                                                         {".css", "text/css; charset=utf-8"},
                                                         {".js", "text/javascript; charset=utf-8"},
                                                         {".svg", "image/svg+xml"}};
  return all;
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  check(file.good(), "{}: cannot read it, expected a file of the studio's page", path.string());
  return bytes.str();
}

const std::string& text_of(const std::map<std::string, PageFile>& files, const std::string& name) {
  const auto found = files.find(name);
  check(found != files.end(), "studio: found no {} among the page's files", name);
  return found->second.bytes;
}

// A module without its words `import ...;` and `export`, which stand at the beginning of lines.
std::string plain_script(const std::string& module) {
  std::string text, line;
  std::istringstream lines(module);
  while (std::getline(lines, line)) {
    if (line.starts_with("import ")) continue;
    text += (line.starts_with("export ") ? line.substr(7) : line) + "\n";
  }
  return text;
}

void replace(std::string& text, const std::string& mark, const std::string& by) {
  const std::size_t at = text.find(mark);
  check(at != std::string::npos, "studio: found no {} in report.html", mark);
  text.replace(at, mark.size(), by);
}

std::string html(const std::string& plain) {
  std::string text;
  for (const char letter : plain) {
    text += letter == '<'   ? "&lt;"
            : letter == '&' ? "&amp;"
            : letter == '"' ? "&quot;"
                            : std::string(1, letter);
  }
  return text;
}

// JSON that no browser takes for the end of its element.
std::string inside_script(const std::string& json) {
  std::string text;
  for (const char letter : json) text += letter == '<' ? "\\u003c" : std::string(1, letter);
  return text;
}

}  // namespace

std::map<std::string, PageFile> page_files() {
  const fs::path folder = fs::path(python_package()) / "studio";
  std::map<std::string, PageFile> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const auto type = types().find(entry.path().extension().string());
    if (type != types().end()) files[entry.path().filename().string()] = {read(entry.path()), type->second};
  }
  check(files.contains("index.html") && files.contains("report.html"),
        "{}: found no page of the studio there, expected index.html and report.html", folder.string());
  return files;
}

std::string report_page(const std::map<std::string, PageFile>& files, const std::string& title,
                        const std::string& run) {
  std::string scripts;
  for (const char* name : kReportScripts) scripts += plain_script(text_of(files, name));
  std::string page = text_of(files, "report.html");
  replace(page, "<!-- title -->", html(title));
  replace(page, "/* style */", text_of(files, "studio.css"));
  replace(page, "/* run */", inside_script(run));
  replace(page, "/* scripts */", scripts);
  return page;
}

}  // namespace s2nnds::studio
