// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/data/recording.h"

namespace s2nnds {
namespace {

constexpr std::string_view kExpectedHeader = "time,x,y[,z][,dx,dy[,dz]] or time,x1,...,xn[,dx1,...,dxn]";

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// The cells of one line, without the blanks around them.
std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t comma = line.find(','); comma != std::string_view::npos; comma = line.find(',')) {
    cells.push_back(trim(line.substr(0, comma)));
    line.remove_prefix(comma + 1);
  }
  cells.push_back(trim(line));
  return cells;
}

std::string read_text(const std::string& path) {
  check_readable(path);
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // the byte order mark that spreadsheets write
  return text;
}

// A text line by line, keeping count. Takes "\n" and "\r\n" as ends of line.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  // The next line that is not blank; false at the end.
  bool next(std::string_view& line) {
    while (!rest_.empty()) {
      const auto end = rest_.find('\n');
      line = trim(rest_.substr(0, end));
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++number_;
      if (!line.empty()) return true;
    }
    return false;
  }
  int number() const { return number_; }

 private:
  std::string_view rest_;
  int number_ = 0;
};

// A cell as a message can show it: one short line whatever the file holds.
std::string shown(std::string_view cell) {
  std::string text(cell.substr(0, 40));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F) c = '?';
  }
  return cell.size() > 40 ? text + "..." : text;
}

std::string axis_name(std::size_t axis, bool numbered) {
  return numbered ? fmt::format("x{}", axis + 1) : std::string(1, "xyz"[axis]);
}

struct Header {
  std::size_t dimension = 0;
  bool velocities = false;

  std::size_t columns() const { return 1 + dimension * (velocities ? 2 : 1); }
};

Header read_header(std::string_view line, const std::string& where) {
  const std::vector<std::string_view> names = cells_of(line);
  check(names[0] == "time", "{}: found first column '{}'; expected the header {}", where, shown(names[0]),
        kExpectedHeader);
  const bool numbered = names.size() > 1 && names[1] == "x1";
  Header header;
  while (1 + header.dimension < names.size() && (numbered || header.dimension < 3) &&
         names[1 + header.dimension] == axis_name(header.dimension, numbered)) {
    ++header.dimension;
  }
  header.velocities = names.size() > 1 + header.dimension;
  for (std::size_t i = 1 + header.dimension; i < names.size(); ++i) {
    const std::size_t axis = i - 1 - header.dimension;
    check(axis < header.dimension && names[i] == fmt::format("d{}", axis_name(axis, numbered)),
          "{}: found column '{}' at place {}; expected the header {}", where, shown(names[i]), i + 1,
          kExpectedHeader);
  }
  check(header.dimension >= 2 && names.size() == header.columns(),
        "{}: found {} column(s); expected the header {}", where, names.size(), kExpectedHeader);
  return header;
}

double read_number(std::string_view cell, const std::string& where) {
  const std::string_view digits = cell.starts_with('+') ? cell.substr(1) : cell;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  check(error == std::errc() && end == digits.data() + digits.size() && std::isfinite(value),
        "{}: found '{}'; expected a finite number", where, shown(cell));
  return value;
}

Demonstration read_demonstration(const std::string& path, std::int64_t stride) {
  const std::string text = read_text(path);
  Lines lines(text);
  std::string_view line;
  check(lines.next(line), "{}:1: found an empty file; expected the header {}", path, kExpectedHeader);
  const Header header = read_header(line, fmt::format("{}:{}", path, lines.number()));
  std::vector<double> numbers;
  double previous = 0;
  while (lines.next(line)) {
    const std::string where = fmt::format("{}:{}", path, lines.number());
    const std::vector<std::string_view> cells = cells_of(line);
    check(cells.size() == header.columns(), "{}: found {} values; expected {} as in the header", where,
          cells.size(), header.columns());
    const double time = read_number(cells[0], where);
    check(numbers.empty() || time > previous, "{}: found time {} after {}; expected increasing times", where,
          time, previous);
    previous = time;
    numbers.push_back(time);
    for (std::size_t i = 1; i < cells.size(); ++i) numbers.push_back(read_number(cells[i], where));
  }
  const auto rows = static_cast<Eigen::Index>(numbers.size() / header.columns());
  check(rows >= 2, "{}:{}: found {} sample(s) in the file; expected at least 2", path, lines.number(), rows);
  const Eigen::Map<const Points> table(numbers.data(), rows, static_cast<Eigen::Index>(header.columns()));
  const auto n = static_cast<Eigen::Index>(header.dimension);
  return make_demonstration(table.col(0), table.middleCols(1, n), table.rightCols(table.cols() - 1 - n),
                            stride, path);
}

}  // namespace

DemonstrationSet read_csv(const std::vector<std::string>& paths, std::int64_t stride) {
  check(!paths.empty(), "csv: found no files; expected one for each demonstration");
  DemonstrationSet set{stem(paths.front()), "", {}};
  for (const std::string& path : paths) {
    set.demonstrations.push_back(read_demonstration(path, stride));
    const Eigen::Index n = set.demonstrations.back().dimension();
    check(n == set.dimension(), "{}: found {} position columns; expected {} as in {}", path, n,
          set.dimension(), paths.front());
  }
  return set;
}

}  // namespace s2nnds
