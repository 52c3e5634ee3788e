// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace s2nnds {

// The files that `patterns` name, below `folder` where they are relative: a file, a folder (all files in it
// with one of these `endings`, ".csv"), or a pattern of file names with * ? and [...] ("day1/d*.csv"). Files
// of a folder or a pattern are in order of name, numbers in them by value (d2 before d10). Throws Error
// for a file that is not there and for a folder or a pattern without files.
std::vector<std::string> find_data_files(const std::vector<std::string>& patterns, const std::string& folder,
                                         const std::vector<std::string>& endings);

}  // namespace s2nnds
