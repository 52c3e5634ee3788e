// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

namespace s2nnds {

// A setting is a text "a.b.c=value" that sets one key of a TOML document, as the command line gives it
// (`--set`). The value is TOML; what is not TOML counts as a string, so that profile=paper needs no quotes. A
// number within the key picks an element of an array ("of.0.radius").

// Parses TOML; throws Error with `source` and line when `text` is not TOML.
toml::table parse_toml(const std::string& text, const std::string& source);

// Makes one setting in `document`. Throws Error naming the setting when it cannot be made.
void apply_setting(toml::table& document, const std::string& setting);

// The TOML `text` with `settings` made, in order: a document for itself, without the comments. Without
// settings, the text as it is. Throws Error as the two above.
std::string with_settings(const std::string& text, const std::string& source,
                          const std::vector<std::string>& settings);

}  // namespace s2nnds
