// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/options.h"
#include "s2nnds/core/printable.h"

namespace s2nnds {

// What files, messages and the command line call the values of an enum class that count from 0. Specialised
// beside the enum:
//   template <>
//   struct EnumNames<Verdict> {
//     static constexpr std::string_view what = "verdict";
//     static constexpr auto names = std::to_array<std::string_view>({"passed", "failed"});
//   };
template <typename E>
struct EnumNames;

// An enum class that has EnumNames.
template <typename E>
concept NamedEnum = std::is_enum_v<E> && requires {
  { EnumNames<E>::what } -> std::convertible_to<std::string_view>;
  EnumNames<E>::names.size();
};

// The name of `value`, which must be one of the enumerators.
template <NamedEnum E>
constexpr std::string_view to_string(E value) {
  return EnumNames<E>::names[static_cast<std::size_t>(value)];
}

// The value that has this name. Throws Error that lists the names there are.
template <NamedEnum E>
E enum_from(std::string_view name) {
  const auto& names = EnumNames<E>::names;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (names[k] == name) return static_cast<E>(k);
  }
  fail("{}: found \"{}\", expected one of {}", EnumNames<E>::what, printable(std::string(name), 200),
       fmt::join(names, ", "));
}

// Visits a field that holds one of the names: `value` becomes the one that the visitor leaves there.
template <NamedEnum E>
void visit_enum(FieldVisitor& v, std::string_view name, E& value) {
  const auto& names = EnumNames<E>::names;
  std::string text(to_string(value));
  v.field(name, text, {names.begin(), names.end()});
  value = enum_from<E>(text);
}

}  // namespace s2nnds
