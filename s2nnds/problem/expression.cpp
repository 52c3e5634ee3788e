#include "s2nnds/problem/expression.h"

#include <torch/csrc/jit/frontend/parser.h>

#include <charconv>
#include <map>
#include <memory>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

namespace jit = torch::jit;
using Operation = ExpressionTree::Operation;

// The front end recurses on the text's structure; beyond these bounds it could run out of stack.
constexpr std::size_t kLongestText = 10000;
constexpr int kDeepestNesting = 200;
constexpr int kMostSigns = 2000;

std::string excerpt(const std::string& text) {
  return text.size() <= 100 ? text : fmt::format("{}...", text.substr(0, 97));
}

// The text with what the front end would read as something else made plain: ^ means power, line breaks mean
// nothing.
std::string prepare(const std::string& text) {
  static const std::string allowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.,()+-*/^ \t\r\n";
  check(text.size() <= kLongestText, "expression: {} characters, expected at most {}", text.size(),
        kLongestText);
  std::string prepared;
  int depth = 0;
  int signs = 0;  // minus signs and powers nest without parentheses
  char previous = ' ';
  for (char c : text) {
    check(allowed.find(c) != std::string::npos, "expression \"{}\": unexpected character '{}'", excerpt(text),
          c >= ' ' && c <= '~' ? std::string(1, c) : "outside ASCII");
    depth += (c == '(') - (c == ')');
    signs += c == '-' || c == '^' || (c == '*' && previous == '*');
    previous = c;
    if (c == '^') {
      prepared += "**";
    } else {
      prepared += c == '\n' || c == '\r' || c == '\t' ? ' ' : c;
    }
    check(depth <= kDeepestNesting && signs <= kMostSigns, "expression \"{}\": nested too deeply",
          excerpt(text));
  }
  return prepared + ' ';  // the front end loses a number at the very end of its text
}

// Converts the front end's tree, node by node.
class Converter {
 public:
  Converter(const std::string& text, Eigen::Index dimension) : text_(text), tree_(dimension) {}

  ExpressionTree convert(const jit::Expr& expression) {
    tree_.set_root(node(expression));
    return std::move(tree_);
  }

 private:
  template <typename... Args>
  [[noreturn]] void reject(fmt::format_string<Args...> message, Args&&... args) const {
    fail("expression \"{}\": {}", excerpt(text_), fmt::format(message, std::forward<Args>(args)...));
  }

  int node(const jit::Expr& expression) {
    switch (expression.kind()) {
      case jit::TK_CONST:
        return number(expression.tree()->tree(0)->stringValue());
      case jit::TK_VAR:
        return name(jit::Var(expression).name().name());
      case jit::TK_APPLY:
        return call(jit::Apply(expression));
      case jit::TK_UNARY_MINUS:
        return tree_.apply(Operation::negate, argument(expression, 0));
      case '+':
        return binary(Operation::add, expression);
      case '-':
        return binary(Operation::subtract, expression);
      case '*':
        return binary(Operation::multiply, expression);
      case '/':
        return binary(Operation::divide, expression);
      case jit::TK_POW:
        return binary(Operation::power, expression);
      default:
        reject("'{}' is not arithmetic", jit::kindToString(expression.kind()));
    }
  }

  int argument(const jit::Expr& expression, std::size_t index) {
    return node(jit::Expr(expression.tree()->tree(index)));
  }

  int binary(Operation operation, const jit::Expr& expression) {
    const int first = argument(expression, 0);
    return tree_.apply(operation, first, argument(expression, 1));
  }

  int number(const std::string& digits) {
    double value = 0.0;
    const char* end = digits.data() + digits.size();
    const auto [stopped, error] = std::from_chars(digits.data(), end, value);
    if (error != std::errc() || stopped != end) reject("'{}' is not a number within range", digits);
    return tree_.constant(value);
  }

  int name(const std::string& symbol) {
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

  int call(const jit::Apply& apply) {
    if (apply.callee().kind() != jit::TK_VAR) reject("only named functions can be called");
    const std::string function = jit::Var(apply.callee()).name().name();
    if (function == "xi") return indexed_variable(apply);
    if (function == "max") return extremum(Operation::max, apply);
    if (function == "min") return extremum(Operation::min, apply);
    static const std::map<std::string, Operation> functions = {
        {"sin", Operation::sin}, {"cos", Operation::cos},  {"tan", Operation::tan},
        {"exp", Operation::exp}, {"log", Operation::log},  {"sqrt", Operation::sqrt},
        {"abs", Operation::abs}, {"tanh", Operation::tanh}};
    const auto found = functions.find(function);
    if (found == functions.end()) {
      reject("unknown function '{}', expected max, min, sin, cos, tan, exp, log, sqrt, abs or tanh",
             function);
    }
    if (apply.inputs().size() != 1) {
      reject("{} has {} arguments, expected 1", function, apply.inputs().size());
    }
    return tree_.apply(found->second, node(apply.inputs()[0]));
  }

  int indexed_variable(const jit::Apply& apply) {
    if (apply.inputs().size() != 1 || apply.inputs()[0].kind() != jit::TK_CONST) {
      reject("xi needs one index from 1 to {}", tree_.dimension());
    }
    return name("xi" + apply.inputs()[0].tree()->tree(0)->stringValue());
  }

  int extremum(Operation operation, const jit::Apply& apply) {
    const auto inputs = apply.inputs();
    if (inputs.size() < 2) {
      reject("{} has {} arguments, expected at least 2", operation == Operation::max ? "max" : "min",
             inputs.size());
    }
    int result = node(inputs[0]);
    for (std::size_t i = 1; i < inputs.size(); ++i) result = tree_.apply(operation, result, node(inputs[i]));
    return result;
  }

  const std::string& text_;
  ExpressionTree tree_;
};

std::string first_line(const std::string& message) { return message.substr(0, message.find('\n')); }

}  // namespace

ExpressionTree parse_expression(const std::string& text, Eigen::Index dimension) {
  const std::string prepared = prepare(text);
  try {
    jit::Parser parser(std::make_shared<jit::Source>(prepared));
    const jit::Expr parsed = parser.parseExp();
    jit::Token next = parser.lexer().cur();
    check(next.kind == jit::TK_EOF, "expression \"{}\": does not parse: unexpected '{}'", excerpt(text),
          next.text());
    return Converter(text, dimension).convert(parsed);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    // "expected ident but found 'eof' here:" and a drawing of the place, of which the first line is the
    // message.
    std::string message = first_line(error.what());
    if (message.ends_with(" here:")) message.resize(message.size() - 6);
    fail("expression \"{}\": does not parse: {}", excerpt(text), message);
  }
}

}  // namespace s2nnds
