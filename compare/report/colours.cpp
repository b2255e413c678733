#include "compare/report/colours.h"

#include <array>
#include <utility>

namespace concord::compare {

namespace {

using Paint = std::pair<std::string_view, std::string_view>;

constexpr std::array kPaints{Paint{"agree", "\033[32m"},     Paint{"differ", "\033[31m"},
                             Paint{"failed", "\033[31m"},    Paint{"could not finish", "\033[31m"},
                             Paint{"bad input", "\033[31m"}, Paint{"not judged", "\033[33m"},
                             Paint{"not unique", "\033[33m"}};

/// What stands at `at` fills a cell of a table: `word`, between bars and spaces.
bool fills_cell(std::string_view text, std::size_t at, std::string_view word) {
  const std::size_t before = text.find_last_not_of(' ', at - 1);
  const std::size_t after = text.find_first_not_of(' ', at + word.size());
  return before != std::string_view::npos && before + 1 < at && text[before] == '|' &&
         after != std::string_view::npos && text[after] == '|';
}

const Paint* paint_at(std::string_view text, std::size_t at) {
  const bool begins_line = at == 0 || text[at - 1] == '\n';
  if (!begins_line && text[at - 1] != ' ') return nullptr;
  for (const Paint& paint : kPaints) {
    if (!text.substr(at).starts_with(paint.first)) continue;
    const std::size_t end = at + paint.first.size();
    const bool is_word = end < text.size() && (text[end] == ' ' || text[end] == ':' || text[end] == ',');
    if (begins_line ? is_word : fills_cell(text, at, paint.first)) return &paint;
  }
  return nullptr;
}

}  // namespace

std::string in_colours(std::string_view text) {
  std::string painted;
  for (std::size_t at = 0; at < text.size();) {
    const Paint* paint = paint_at(text, at);
    if (paint == nullptr) {
      painted += text[at++];
      continue;
    }
    painted.append(paint->second).append(paint->first).append("\033[0m");
    at += paint->first.size();
  }
  return painted;
}

std::string shown(const Console& console, const std::string& text) { return console.colours ? in_colours(text) : text; }

}  // namespace concord::compare
