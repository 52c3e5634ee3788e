// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/expression.h"

#include <charconv>
#include <map>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"

namespace s2nnds {
namespace {

using Operation = ExpressionTree::Operation;

constexpr std::size_t kLongestText = 10000;  // characters
constexpr int kDeepestNesting = 200;         // the parser recurses: deeper texts could run out of stack

constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::string_view kDigits = "0123456789";
constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
constexpr std::string_view kSigns = ".,()+-*/^";

bool is_one_of(char c, std::string_view characters) { return characters.find(c) != std::string_view::npos; }

// By recursive descent, one function a rule:
//   sum     = product { ("+" | "-") product }
//   product = factor { ("*" | "/") factor }
//   factor  = { "-" } power
//   power   = primary [ ("^" | "**") factor ]    (from the right, and tighter than a minus sign before it)
//   primary = number | name | name "(" sum { "," sum } ")" | "(" sum ")"
class Parser {
 public:
  Parser(const std::string& text, Eigen::Index dimension) : text_(text), tree_(dimension) {}

  ExpressionTree parse() {
    if (text_.size() > kLongestText) reject("{} characters, expected at most {}", text_.size(), kLongestText);
    tree_.set_root(sum());
    if (!at_end()) unexpected();
    return std::move(tree_);
  }

 private:
  template <typename... Args>
  [[noreturn]] void reject(fmt::format_string<Args...> message, Args&&... args) const {
    std::string excerpt = text_.size() <= 100 ? text_ : text_.substr(0, 97) + "...";
    for (char& c : excerpt) c = is_one_of(c, kBlanks) ? ' ' : c;
    fail("expression \"{}\": {}", printable(excerpt), fmt::format(message, std::forward<Args>(args)...));
  }

  [[noreturn]] void unexpected() {
    if (at_end()) reject("does not parse: it ends too early");
    const char c = text_[at_];
    if (c < ' ' || c > '~') reject("unexpected character outside ASCII");
    std::string word = number();
    if (word.empty()) word = name();
    if (word.empty() && !is_one_of(c, kSigns)) reject("unexpected character '{}'", c);
    reject("does not parse: unexpected '{}'", word.empty() ? std::string(1, c) : word);
  }

  // ---- Words

  bool at_end() {
    at_ = std::min(text_.find_first_not_of(kBlanks, at_), text_.size());
    return at_ == text_.size();
  }

  bool take(std::string_view sign) {
    if (at_end() || text_.compare(at_, sign.size(), sign) != 0) return false;
    at_ += sign.size();
    return true;
  }

  void expect(std::string_view sign) {
    if (!take(sign)) unexpected();
  }

  // The number or the name that stands here; empty if there is none.
  std::string number() {
    if (at_end() || !is_one_of(text_[at_], "0123456789.")) return "";
    double value = 0.0;
    const char* begin = text_.data() + at_;
    const char* end = std::from_chars(begin, text_.data() + text_.size(), value).ptr;
    at_ += static_cast<std::size_t>(end - begin);
    return {begin, end};
  }
  std::string name() {
    if (at_end() || !is_one_of(text_[at_], kLetters)) return "";
    std::size_t end = at_;
    while (end < text_.size() && (is_one_of(text_[end], kLetters) || is_one_of(text_[end], kDigits))) ++end;
    return text_.substr(std::exchange(at_, end), end - at_);
  }

  // ---- Rules; each returns a node of the tree

  int sum() {
    int result = product();
    while (true) {
      if (take("+")) {
        result = tree_.apply(Operation::add, result, product());
      } else if (take("-")) {
        result = tree_.apply(Operation::subtract, result, product());
      } else {
        return result;
      }
    }
  }

  int product() {
    int result = factor();
    while (true) {
      if (take("*")) {
        result = tree_.apply(Operation::multiply, result, factor());
      } else if (take("/")) {
        result = tree_.apply(Operation::divide, result, factor());
      } else {
        return result;
      }
    }
  }

  int factor() {
    if (depth_++ > kDeepestNesting) reject("nested too deeply");
    int signs = 0;
    while (take("-")) ++signs;
    int result = power();
    for (; signs > 0; --signs) result = tree_.apply(Operation::negate, result);
    --depth_;
    return result;
  }

  int power() {
    const int base = primary();
    return take("^") || take("**") ? tree_.apply(Operation::power, base, factor()) : base;
  }

  int primary() {
    if (take("(")) {
      const int inside = sum();
      expect(")");
      return inside;
    }
    if (const std::string digits = number(); !digits.empty()) return constant(digits);
    const std::string word = name();
    if (word.empty()) unexpected();
    return take("(") ? call(word) : named(word);
  }

  int constant(const std::string& digits) {
    double value = 0.0;
    const std::errc error = std::from_chars(digits.data(), digits.data() + digits.size(), value).ec;
    if (error != std::errc()) reject("'{}' is not a number within range", digits);
    return tree_.constant(value);
  }

  int named(const std::string& symbol) {
    if (symbol == "pi") return tree_.constant(pi_interval().lower, pi_interval());
    const Eigen::Index axis = axis_of(symbol);
    if (axis < 0 || axis >= tree_.dimension()) {
      reject("unknown name '{}', expected x, y, z or x1 to x{} (dimension {}), pi, or a function", symbol,
             tree_.dimension(), tree_.dimension());
    }
    return tree_.variable(axis);
  }

  // Counted from 0; -1 if the name is not that of a variable.
  static Eigen::Index axis_of(const std::string& symbol) {
    if (symbol.size() == 1) return symbol[0] >= 'x' && symbol[0] <= 'z' ? symbol[0] - 'x' : -1;
    const std::size_t prefix = symbol.starts_with("xi") ? 2 : symbol.starts_with("x") ? 1 : 0;
    int index = 0;
    const char* end = symbol.data() + symbol.size();
    const auto [stopped, error] = std::from_chars(symbol.data() + prefix, end, index);
    return prefix > 0 && error == std::errc() && stopped == end ? index - 1 : -1;
  }

  // After the opening parenthesis.
  int call(const std::string& function) {
    if (function == "xi") return indexed_variable();
    static const std::map<std::string, Operation> functions = {
        {"sin", Operation::sin}, {"cos", Operation::cos},   {"tan", Operation::tan},
        {"exp", Operation::exp}, {"log", Operation::log},   {"sqrt", Operation::sqrt},
        {"abs", Operation::abs}, {"tanh", Operation::tanh}, {"max", Operation::max},
        {"min", Operation::min}};
    const auto found = functions.find(function);
    if (found == functions.end()) {
      reject("unknown function '{}', expected max, min, sin, cos, tan, exp, log, sqrt, abs or tanh",
             function);
    }
    std::vector<int> arguments;
    do {
      arguments.push_back(sum());
    } while (take(","));
    expect(")");
    const bool many = function == "max" || function == "min";
    if (many ? arguments.size() < 2 : arguments.size() != 1) {
      reject("{} has {} arguments, expected {}", function, arguments.size(), many ? "at least 2" : "1");
    }
    if (!many) return tree_.apply(found->second, arguments[0]);
    int result = arguments[0];
    for (std::size_t i = 1; i < arguments.size(); ++i) {
      result = tree_.apply(found->second, result, arguments[i]);
    }
    return result;
  }

  int indexed_variable() {
    const std::string index = number();
    if (index.empty() || !take(")")) reject("xi needs one index from 1 to {}", tree_.dimension());
    return named("xi" + index);
  }

  const std::string& text_;
  std::size_t at_ = 0;  // the next character
  int depth_ = 0;
  ExpressionTree tree_;
};

}  // namespace

ExpressionTree parse_expression(const std::string& text, Eigen::Index dimension) {
  return Parser(text, dimension).parse();
}

}  // namespace s2nnds
