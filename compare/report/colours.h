#pragma once

#include <string>
#include <string_view>

#include "compare/report/console.h"

namespace concord::compare {

/// The text with its verdicts in colour for a terminal: the words of a verdict that fill a cell of a table or begin a
/// line; green what agrees, red what differs or could not finish, yellow what is open. Without its escape sequences
/// it is the text.
std::string in_colours(std::string_view text);

/// What goes to `console.out`: in colours where it shows them.
std::string shown(const Console& console, const std::string& text);

}  // namespace concord::compare
