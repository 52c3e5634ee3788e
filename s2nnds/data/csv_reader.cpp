// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/data/column_names.h"
#include "s2nnds/data/delimited_text.h"
#include "s2nnds/data/readers.h"
#include "s2nnds/data/recording.h"

namespace s2nnds {
namespace {

std::string read_text(const std::string& path) {
  check_readable(path);
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // the byte order mark that spreadsheets write
  return text;
}

bool is_missing(std::string_view cell) {
  return cell.empty() || cell == "NA" || cell == "null" || cell == "None" || cell == "NULL";
}

// A number with a decimal point in every locale, where commas part no cells also with a decimal comma.
// Missing values, nan and inf are numbers that are not finite.
double read_number(std::string_view cell, bool decimal_comma, const std::string& path, std::int64_t line) {
  if (is_missing(cell)) return std::numeric_limits<double>::quiet_NaN();
  std::string with_point;
  std::string_view digits = cell.starts_with('+') ? cell.substr(1) : cell;
  if (decimal_comma && std::count(digits.begin(), digits.end(), ',') == 1) {
    with_point = digits;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    digits = with_point;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size())
    fail("{}:{}: found '{}'; expected a number (data.columns picks columns)", path, line, shown(cell));
  return value;
}

// Times, of which doubles cannot tell large integers (nanoseconds since 1970) apart.
class TimeColumn {
 public:
  void push_back(std::string_view cell, double value) {
    std::int64_t integer = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), integer);
    exact_ = exact_ && error == std::errc() && end == cell.data() + cell.size();
    if (exact_) integers_.push_back(integer);
    if (!values_.empty()) largest_step_ = std::max(largest_step_, value - values_.back());
    values_.push_back(value);
  }
  std::size_t size() const { return values_.size(); }

  // Whether `next` goes on from here: its first time comes after the last one here, by no more than ten steps.
  bool goes_on_in(const TimeColumn& next) const {
    const double gap = next.values_.front() - values_.back();
    const double step = std::max(largest_step_, next.largest_step_);
    return gap > 0 && (step == 0 || gap <= 10 * step);
  }
  void append(const TimeColumn& next) {
    largest_step_ = std::max({largest_step_, next.largest_step_, next.values_.front() - values_.back()});
    values_.insert(values_.end(), next.values_.begin(), next.values_.end());
    exact_ = exact_ && next.exact_;
    integers_.insert(integers_.end(), next.integers_.begin(), next.integers_.end());
  }

  // Moves the times to the recording.
  void store(Recording& recording) const {
    constexpr std::int64_t kLargest = std::int64_t{1} << 53;
    const auto size = static_cast<Eigen::Index>(values_.size());
    const bool large = exact_ && std::any_of(integers_.begin(), integers_.end(),
                                             [](std::int64_t t) { return t > kLargest; });
    recording.time = Eigen::Map<const Vector>(values_.data(), size);
    if (!large) return;
    recording.time_offset = static_cast<double>(integers_.front());
    for (Eigen::Index i = 0; i < size; ++i) {
      // Unsigned: the difference of any two fits.
      const auto difference = static_cast<std::uint64_t>(integers_[static_cast<std::size_t>(i)]) -
                              static_cast<std::uint64_t>(integers_.front());
      recording.time[i] = static_cast<double>(static_cast<std::int64_t>(difference));
    }
  }

 private:
  std::vector<double> values_;
  std::vector<std::int64_t> integers_;
  bool exact_ = true;
  double largest_step_ = 0;
};

// The samples of one demonstration while its lines are read.
struct Samples {
  TimeColumn time;
  std::vector<double> position;     // [M n]
  std::vector<double> velocity;     // [M n] or none
  std::vector<double> orientation;  // [M 4] or [M 9] or none
  std::vector<std::int64_t> lines;
  bool after_blank = false;  // whether blank lines part it from the one before

  bool empty() const { return lines.empty(); }
};

class CsvFile {
 public:
  CsvFile(const std::string& path, const TableOptions& options, const ReadingProgress& progress)
      : path_(path),
        options_(options),
        text_(read_text(path)),
        header_(read_text_header(text_, options.delimiter, path)),
        splitter_(options.delimiter, header_.sample),
        columns_(find_columns(
            header_.names, header_.named, options.rate <= 0, options.columns,
            fmt::format("{}:{}", path, std::max<std::int64_t>(1, header_.first_data_line - 1)))) {
    has_orientations_ = !columns_.orientation.empty();
    if (options.state != "pose") columns_.orientation.clear();
    check(options.state != "pose" || !columns_.orientation.empty(), "{}: {}", path, kNoOrientation);
    read_lines(progress);
  }

  std::vector<Recording> recordings() const {
    std::vector<Recording> made;
    for (const Samples& part : parts_) made.push_back(recording(part));
    return made;
  }
  std::string unit() const { return columns_.unit; }
  bool has_orientations() const { return has_orientations_; }
  std::string quaternion_order() const { return columns_.quaternion_order; }

  std::string report() const {
    std::string text = fmt::format("columns of {}: {}", stem(path_), describe(columns_, header_.names));
    if (!header_.named) text += fmt::format(", no header, data from line {}", header_.first_data_line);
    if (!splitter_.is_comma()) text += fmt::format(", delimiter: {}", splitter_.name());
    return text;
  }
  std::size_t parts() const { return parts_.size(); }

 private:
  void read_lines(const ReadingProgress& progress) {
    Lines lines(text_);
    std::string_view line;
    std::vector<std::string_view> cells;
    bool blank = false;
    while (lines.next(line)) {
      if (progress && lines.number() % samples_a_tick == 0) progress("reading " + path_, lines.share());
      if (lines.number() < header_.first_data_line) continue;
      if (line.empty()) {
        blank = !parts_.empty();
        continue;
      }
      if (line.starts_with('#')) continue;
      splitter_.split(line, cells);
      if (cells.size() == header_.names.size() + 1 && cells.back().empty()) cells.pop_back();
      check(cells.size() == header_.names.size(), "{}:{}: found {} values; expected {} as in {}", path_,
            lines.number(), cells.size(), header_.names.size(),
            header_.named ? "the header" : "the first line");
      take(cells, lines.number(), std::exchange(blank, false));
    }
    join_continued_parts();
    if (parts_.empty()) parts_.emplace_back();
    for (const Samples& part : parts_) {
      check(part.lines.size() >= 2, "{}:{}: found {} sample(s) in {}; expected at least 2", path_,
            part.empty() ? lines.number() : part.lines.back(), part.lines.size(),
            parts_.size() > 1 ? "a demonstration" : "the file");
    }
  }

  void take(const std::vector<std::string_view>& cells, std::int64_t line, bool after_blank) {
    const bool by_index = columns_.index && (parts_.empty() || cells[*columns_.index] != index_);
    if (by_index) {
      index_ = cells[*columns_.index];
      check(std::find(indices_.begin(), indices_.end(), index_) == indices_.end(),
            "{}:{}: found index '{}' again after another; expected the samples of a demonstration together",
            path_, line, shown(index_));
      indices_.push_back(index_);
    }
    if (parts_.empty() || by_index || (after_blank && !columns_.index)) {
      parts_.emplace_back();
      parts_.back().after_blank = after_blank && !by_index;
    }
    Samples& part = parts_.back();
    const auto number = [&](std::size_t place) {
      return read_number(cells[place], !splitter_.is_comma(), path_, line);
    };
    if (columns_.time) {
      part.time.push_back(cells[*columns_.time], number(*columns_.time));
    } else {
      part.time.push_back("", static_cast<double>(part.time.size()) / options_.rate);
    }
    for (const std::size_t place : columns_.position) part.position.push_back(number(place));
    for (const std::size_t place : columns_.velocity) part.velocity.push_back(number(place));
    for (const std::size_t place : columns_.orientation) part.orientation.push_back(number(place));
    part.lines.push_back(line);
  }

  // Blank lines part demonstrations; but where the time runs on, they are only blank lines.
  void join_continued_parts() {
    if (!columns_.time) return;
    std::vector<Samples> joined;
    for (Samples& part : parts_) {
      if (!joined.empty() && part.after_blank && joined.back().time.goes_on_in(part.time)) {
        append(joined.back(), part);
      } else {
        joined.push_back(std::move(part));
      }
    }
    parts_ = std::move(joined);
  }

  static void append(Samples& to, const Samples& from) {
    to.time.append(from.time);
    to.position.insert(to.position.end(), from.position.begin(), from.position.end());
    to.velocity.insert(to.velocity.end(), from.velocity.begin(), from.velocity.end());
    to.orientation.insert(to.orientation.end(), from.orientation.begin(), from.orientation.end());
    to.lines.insert(to.lines.end(), from.lines.begin(), from.lines.end());
  }

  Recording recording(const Samples& part) const {
    const auto rows = static_cast<Eigen::Index>(part.lines.size());
    const auto n = static_cast<Eigen::Index>(columns_.position.size());
    Recording made{path_, columns_.time ? header_.names[*columns_.time] : "", 0, {}, {}, {}, part.lines};
    part.time.store(made);
    made.position = Eigen::Map<const Points>(part.position.data(), rows, n);
    if (!columns_.velocity.empty()) made.velocity = Eigen::Map<const Points>(part.velocity.data(), rows, n);
    const auto parts = static_cast<Eigen::Index>(columns_.orientation.size());
    if (parts > 0) made.orientation = Eigen::Map<const Points>(part.orientation.data(), rows, parts);
    return made;
  }

  const std::string& path_;
  const TableOptions& options_;
  std::string text_;
  TextHeader header_;
  CellSplitter splitter_;
  Columns columns_;
  bool has_orientations_ = false;
  std::string_view index_;
  std::vector<std::string_view> indices_;
  std::vector<Samples> parts_;
};

}  // namespace

RecordingSet read_csv(const std::vector<std::string>& paths, const TableOptions& options,
                      const ReadingProgress& progress) {
  check(!paths.empty(), "csv: found no files; expected one for each demonstration (data.files)");
  RecordingSet set{stem(paths.front()), ""};
  if (options.rate > 0) set.time_unit = 1;
  for (const std::string& path : paths) {
    const CsvFile file(path, options, progress);
    for (Recording& recording : file.recordings()) {
      const Eigen::Index n = recording.position.cols();
      const Eigen::Index first = set.recordings.empty() ? n : set.recordings.front().position.cols();
      check(n == first, "{}: found {} position columns; expected {} as in {}", path, n, first, paths.front());
      set.recordings.push_back(std::move(recording));
    }
    if (&path == &paths.front()) set.unit = file.unit();
    if (&path == &paths.front()) set.quaternion_order = file.quaternion_order();
    set.has_orientations = set.has_orientations || file.has_orientations();
    check(set.quaternion_order == file.quaternion_order(), "{}: found quaternions {}; expected {} as in {}",
          path, file.quaternion_order(), set.quaternion_order, paths.front());
    if (&path == &paths.front()) set.report.push_back(file.report());
    if (file.parts() > 1)
      set.report.push_back(fmt::format("{}: {} demonstrations in one file", stem(path), file.parts()));
  }
  return set;
}

}  // namespace s2nnds
