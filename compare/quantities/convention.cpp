#include "compare/quantities/convention.h"

#include <fmt/format.h>

#include <array>

namespace concord::compare {

namespace {

/// One word of a header, and its value where the flag behind it is false, and true.
struct Word {
  const char* name;
  std::array<const char*, 2> values;
};

constexpr std::array<Word, 4> kWords{{{"side", {"child", "parent"}},
                                      {"axes", {"joint", "world"}},
                                      {"driver", {"without", "with"}},
                                      {"sign", {"same", "opposite"}}}};

std::optional<bool> flag_of(const Convention& convention, std::size_t word) {
  if (word == 0) return convention.side ? std::optional(*convention.side == Side::parent) : std::nullopt;
  return word == 1 ? convention.in_world_axes : word == 2 ? convention.with_driver : convention.opposite;
}

void set_flag(std::size_t word, bool flag, Convention& convention) {
  if (word == 0) {
    convention.side = flag ? Side::parent : Side::child;
    return;
  }
  (word == 1 ? convention.in_world_axes : word == 2 ? convention.with_driver : convention.opposite) = flag;
}

Field wrench_field(bool with_driver, bool in_world_axes) {
  if (with_driver) return in_world_axes ? Field::total_global : Field::total;
  return in_world_axes ? Field::reaction_global : Field::reaction;
}

}  // namespace

bool has_convention(const Column& column) {
  return column.field >= Field::reaction && column.field <= Field::total_global;
}

Column in_convention(const Column& column, const Convention& convention) {
  if (!has_convention(column)) return column;
  const bool is_total = column.field == Field::total || column.field == Field::total_global;
  const bool is_global = column.field == Field::reaction_global || column.field == Field::total_global;
  Column other = column;
  other.side = convention.side.value_or(column.side);
  other.field = wrench_field(convention.with_driver.value_or(is_total), convention.in_world_axes.value_or(is_global));
  return other;
}

double sign_in(const Column& column, const Convention& convention) {
  return has_convention(column) && convention.opposite.value_or(false) ? -1.0 : 1.0;
}

std::vector<std::string> header_lines(const Convention& convention, const std::string& joint) {
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < kWords.size(); ++k) {
    const std::optional<bool> flag = flag_of(convention, k);
    if (!flag) continue;
    lines.push_back(
        fmt::format("# {}{}{} = {}", kWords[k].name, joint.empty() ? "" : " ", joint, kWords[k].values[*flag ? 1 : 0]));
  }
  return lines;
}

bool say(const std::string& word, const std::string& value, Convention& convention) {
  for (std::size_t k = 0; k < kWords.size(); ++k) {
    if (word != kWords[k].name) continue;
    for (const bool flag : {false, true}) {
      if (value != kWords[k].values[flag ? 1 : 0]) continue;
      set_flag(k, flag, convention);
      return true;
    }
  }
  return false;
}

std::string words_of_conventions() {
  std::string text;
  for (const Word& word : kWords) {
    text += fmt::format("{}`{} = {}` or `{}`", text.empty() ? "" : ", ", word.name, word.values[0], word.values[1]);
  }
  return text;
}

std::vector<Convention> all_conventions() {
  std::vector<Convention> all;
  for (unsigned int bits = 0; bits < 16; ++bits) {
    Convention one;
    for (std::size_t k = 0; k < kWords.size(); ++k) set_flag(k, (bits >> k & 1U) != 0, one);
    all.push_back(one);
  }
  return all;
}

}  // namespace concord::compare
