// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/delimited_text.h"

#include <algorithm>
#include <charconv>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view trim(std::string_view text, std::string_view blanks = kBlanks) {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string_view unquoted(std::string_view cell) {
  cell = trim(cell);
  const bool quoted = cell.size() >= 2 && cell.front() == '"' && cell.back() == '"';
  return quoted ? trim(cell.substr(1, cell.size() - 2)) : cell;
}

bool is_comment(std::string_view line) { return line.starts_with('#') || line.starts_with('%'); }

// "# time x y" -> "time x y"; a name that begins with the mark, as "%time", loses it.
std::string_view without_mark(std::string_view line) {
  const auto first = line.find_first_not_of("#%");
  return first == std::string_view::npos ? std::string_view{} : trim(line.substr(first));
}

std::vector<std::string> names_in(const std::vector<std::string_view>& cells) {
  std::vector<std::string> names;
  for (const std::string_view cell : cells) names.emplace_back(shown(cell));
  return names;
}

bool any_number(const std::vector<std::string_view>& cells) {
  return std::any_of(cells.begin(), cells.end(), [](std::string_view cell) { return reads_as_number(cell); });
}

// 0, 1, 2, ...: the names that pandas gives to columns without names.
bool counts(const std::vector<std::string_view>& cells) {
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i] != std::to_string(i)) return false;
  return cells.size() > 2;
}

}  // namespace

bool Lines::next(std::string_view& line) {
  if (rest_.empty()) return false;
  const auto end = rest_.find('\n');
  line = rest_.substr(0, end);
  line = trim(line).empty() ? std::string_view{} : trim(line, " \r");  // a tab may stand for an empty cell
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  ++number_;
  return true;
}

double Lines::share() const {
  return size_ == 0 ? 1.0 : 1.0 - static_cast<double>(rest_.size()) / static_cast<double>(size_);
}

CellSplitter::CellSplitter(const std::string& delimiter, std::string_view line) {
  const auto has = [&](char c) { return line.find(c) != std::string_view::npos; };
  if (delimiter == "auto") {
    delimiter_ = has(';') ? ';' : has('\t') ? '\t' : has(',') ? ',' : ' ';
  } else {
    delimiter_ = delimiter == "comma"       ? ','
                 : delimiter == "semicolon" ? ';'
                 : delimiter == "tab"       ? '\t'
                                            : ' ';
  }
}

std::string_view CellSplitter::name() const {
  return delimiter_ == ','    ? "comma"
         : delimiter_ == ';'  ? "semicolon"
         : delimiter_ == '\t' ? "tab"
                              : "blanks";
}

void CellSplitter::split(std::string_view line, std::vector<std::string_view>& cells) const {
  cells.clear();
  if (delimiter_ == ' ') {
    for (auto begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
      const auto end = std::min(line.find_first_of(kBlanks, begin), line.size());
      cells.push_back(unquoted(line.substr(begin, end - begin)));
      begin = line.find_first_not_of(kBlanks, end);
    }
    return;
  }
  std::size_t begin = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] != delimiter_ || quoted) continue;
    cells.push_back(unquoted(line.substr(begin, i - begin)));
    begin = i + 1;
  }
  cells.push_back(unquoted(line.substr(begin)));
}

std::string shown(std::string_view cell) {
  std::string text(cell.substr(0, 40));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F) c = '?';
  }
  return cell.size() > 40 ? text + "..." : text;
}

bool reads_as_number(std::string_view cell) {
  if (cell.starts_with('+') || cell.starts_with('-')) cell.remove_prefix(1);
  double value = 0;
  std::string point(cell);
  std::replace(point.begin(), point.end(), ',', '.');
  const auto [end, error] = std::from_chars(point.data(), point.data() + point.size(), value);
  return error != std::errc::invalid_argument && end == point.data() + point.size();
}

TextHeader read_text_header(std::string_view text, const std::string& delimiter, const std::string& path) {
  Lines lines(text);
  TextHeader header;
  std::string_view line, comment;
  do {
    check(lines.next(line), "{}:1: found no line of data; expected a table of numbers", path);
    if (is_comment(line)) comment = line;
  } while (line.empty() || is_comment(line));
  header.sample = line;
  const CellSplitter splitter(delimiter, line);
  std::vector<std::string_view> cells, words;
  splitter.split(line, cells);
  header.named = !any_number(cells);
  if (header.named || counts(cells)) {
    header.names = names_in(cells);
    header.first_data_line = lines.number() + 1;
    return header;
  }
  header.first_data_line = lines.number();
  splitter.split(without_mark(comment), words);
  header.named = words.size() == cells.size() && !any_number(words);
  if (header.named) {
    header.names = names_in(words);
    return header;
  }
  for (std::size_t i = 0; i < cells.size(); ++i) header.names.push_back(std::to_string(i));
  return header;
}

}  // namespace s2nnds
