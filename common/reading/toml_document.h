#pragma once

#include <toml++/toml.h>

#include <string>
#include <string_view>

/// TOML as toml++ has it: a document, and what its values are.
namespace concord {

/// The document; throws InputError where TOML's own grammar is broken, and where it is nested deeper or holds more
/// values than any model needs: such a document would use up stack or memory.
toml::table parse_toml(std::string_view text, const std::string& file);

/// Title of a table in messages: "joint 'A'", or "joint" if it has no name.
std::string title_with_name(const toml::table& table, std::string_view kind);

/// Name of a value's type in messages: "a number", "a string", ...
std::string_view type_name(const toml::node& node);

/// The number of a node that is one. A whole number that double precision does not hold is rounded to one it holds.
double number_in(const toml::node& node);

}  // namespace concord
