// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/file_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "s2nnds/core/check.h"
#include "s2nnds/data/delimited_text.h"

namespace s2nnds {
namespace {

// The number that the whole word says, if it is one.
template <typename T>
bool parse(std::string_view word, T& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() && !word.empty();
}

}  // namespace

bool FileText::next(std::vector<std::string_view>& words) {
  while (position_ < text_.size()) {
    const std::size_t end = std::min(text_.find('\n', position_), text_.size());
    std::string_view line = text_.substr(position_, end - position_);
    position_ = std::min(end + 1, text_.size());
    ++line_;
    line = line.substr(0, line.find('#'));
    words.clear();
    const std::string gaps = " \t\r" + also_;
    for (std::size_t first = line.find_first_not_of(gaps); first != std::string_view::npos;) {
      const std::size_t last = std::min(line.find_first_of(gaps, first), line.size());
      words.push_back(line.substr(first, last - first));
      first = line.find_first_not_of(gaps, last);
    }
    if (!words.empty()) return true;
  }
  return false;
}

std::string FileText::where() const { return fmt::format("{}:{}", name_, line_); }

double FileText::number(std::string_view word) const {
  double value = 0.0;
  if (!parse(word, value) || !std::isfinite(value)) {
    fail("{}: found '{}', expected a finite number", where(), shown(word));
  }
  return value;
}

std::int64_t FileText::integer(std::string_view word) const {
  std::int64_t value = 0;
  if (!parse(word, value)) fail("{}: found '{}', expected an integer", where(), shown(word));
  return value;
}

bool is_number(std::string_view word) {
  double value = 0.0;
  return parse(word, value);
}

std::string ending_of(const std::string& name) {
  std::string ending = std::filesystem::path(name).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending.empty() ? ending : ending.substr(1);
}

}  // namespace s2nnds
