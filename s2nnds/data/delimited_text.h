// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace s2nnds {

// A text line by line, keeping count. Takes "\n" and "\r\n" as ends of line.
class Lines {
 public:
  explicit Lines(std::string_view text) : size_(text.size()), rest_(text) {}

  // The next line without the blanks around it; false at the end.
  bool next(std::string_view& line);
  std::int64_t number() const { return number_; }  // of the line that next() gave, from 1
  // Of the text that has been read, in [0, 1].
  double share() const;

 private:
  std::size_t size_;
  std::string_view rest_;
  std::int64_t number_ = 0;
};

// Splits lines at commas, semicolons, tabs or runs of blanks; a cell may stand in double quotes.
class CellSplitter {
 public:
  // comma, semicolon, tab, blanks, or auto: what stands in `line`, the first of semicolon, tab, comma, else
  // blanks.
  CellSplitter(const std::string& delimiter, std::string_view line);

  // The cells of a line, without the blanks and quotes around them. They view `line`.
  void split(std::string_view line, std::vector<std::string_view>& cells) const;
  bool is_comma() const { return delimiter_ == ','; }
  std::string_view name() const;  // comma, semicolon, tab, blanks

 private:
  char delimiter_;
};

// A cell as a message can show it: one short line whatever the file holds.
std::string shown(std::string_view cell);

// What a file's columns are called, and where its data begin.
struct TextHeader {
  std::vector<std::string> names;    // of the columns; their numbers from 0 where there is no header
  bool named = false;                // whether the file has a header
  std::int64_t first_data_line = 0;  // from 1: what stands before is header or comment; 0: there is none
  std::string_view sample;           // the first line that is no comment, for the delimiter
};

// Reads over comments ("#" or "%") to the first line of data. The header is the line before it, or the last
// comment if that has as many words as the data columns. A first line 0,1,2,... numbers the columns. Throws Error starting with `path` for an empty file.
TextHeader read_text_header(std::string_view text, const std::string& delimiter, const std::string& path);

// Whether a cell is a number, nan and inf included.
bool reads_as_number(std::string_view cell);

}  // namespace s2nnds
