#include "compare/report/third_table.h"

#include <fmt/format.h>

#include <vector>

#include "compare/quantities/observe.h"
#include "compare/report/text_table.h"
#include "compare/verdict/third_words.h"

namespace concord::compare {

namespace {

std::string third_table_of(const Model& model, const ThirdReport& third, const std::vector<const ThirdRow*>& rows) {
  std::vector<std::vector<std::string>> lines{{"at the same state", "what", "component", "scale",
                                               "cartesian, " + third.name, "relative, " + third.name,
                                               "cartesian, relative", "need", "off"}};
  for (const ThirdRow* row : rows) {
    lines.push_back(
        {describe_owner(model, row->quantity), word_of(row->quantity.kind), describe_component(row->quantity),
         fmt::format("{:.4g} {}", row->scale, unit_of(model, row->quantity)), third_digits_text(row->shared[0].digits),
         third_digits_text(row->shared[1].digits), third_digits_text(row->between.digits),
         fmt::format("{:g}", row->need), name_of(blame_in(*row), third.name)});
  }
  return format_table(lines, {false, false, false, true, true, true, true, true, false});
}

std::string third_summary_of(const ThirdReport& third) {
  std::string text = fmt::format("{} at {}:", third.name, plural(third.states, "state", "states"));
  const auto add = [&](const char* what, Kind kind) {
    if (const auto digits = third.digits(kind)) text += fmt::format(" {} {},", what, third_digits_text(*digits));
  };
  add("accelerations", Kind::acceleration);
  add("reactions", Kind::reaction);
  add("total wrenches", Kind::total);
  add("forces on speeds", Kind::driver);
  add("couplings", Kind::coupling);
  add("sums on bodies", Kind::body_sum);
  text.back() = ';';
  return text + fmt::format(" digits with both, need {:g}\n", kThirdNeed);
}

}  // namespace

std::string format_third(const Model& model, const Verdict& verdict, bool all_rows) {
  if (!verdict.third) return "";
  const ThirdReport& third = *verdict.third;
  if (!third.not_expressible.empty()) {
    return fmt::format("{} was not asked: {}\n", third.name, third.not_expressible);
  }
  if (third.states == 0) return "";
  const auto is_shown = [&](const ThirdRow& row) { return all_rows || row.quantity.kind != Kind::body_sum; };
  std::vector<const ThirdRow*> rows;
  if (all_rows) {
    for (const ThirdRow& row : third.rows) rows.push_back(&row);
  } else {
    rows = worst_third_rows(third.rows, is_shown);
  }
  return '\n' + third_table_of(model, third, rows) + '\n' + third_summary_of(third);
}

}  // namespace concord::compare
