// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace s2nnds {

// The text of a file, line by line, each split into words at blanks and at the characters of `also`. Blank
// lines are passed over, and what follows a '#'. Messages name the file and the line.
class FileText {
 public:
  FileText(std::string_view text, std::string name, std::string_view also = "")
      : text_(text), name_(std::move(name)), also_(also) {}

  // The words of the next line that has some; false at the end. They are views of the text.
  bool next(std::vector<std::string_view>& words);
  std::size_t position() const { return position_; }  // of the first byte behind the last line
  std::string where() const;                          // "FILE:LINE"
  double number(std::string_view word) const;         // throws Error unless it is a finite number
  std::int64_t integer(std::string_view word) const;  // throws Error unless it is an integer

 private:
  std::string_view text_;
  std::string name_;
  std::string also_;
  std::size_t position_ = 0, line_ = 0;
};

// Whether the word is a number, if perhaps not a finite one.
bool is_number(std::string_view word);
// The ending of a file's name in small letters: "a/B.STL" -> "stl".
std::string ending_of(const std::string& name);

}  // namespace s2nnds
