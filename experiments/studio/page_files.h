// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

namespace s2nnds::studio {

// One file of the page.
struct PageFile {
  std::string bytes;
  std::string type;  // as HTTP tells it: "text/css; charset=utf-8"
};

// The page's files by name, read at once: nothing else is ever served. They lie in the folder `studio` of the Python
// package (core/python_module.h). Throws Error when one of them is missing.
std::map<std::string, PageFile> page_files();

// One HTML file that shows a run and needs nothing else, not even a server: the page's style and scripts, and `run`
// (run_json). Its title is `title`.
std::string report_page(const std::map<std::string, PageFile>& files, const std::string& title,
                        const std::string& run);

}  // namespace s2nnds::studio
