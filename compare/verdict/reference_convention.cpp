#include "compare/verdict/reference_convention.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compare/quantities/convention.h"

namespace concord::compare {

namespace {

/// The columns that have conventions, of all joints or of one.
Reference with_conventions(const Reference& whole, std::optional<int> joint) {
  Reference part = whole;
  std::erase_if(part.columns, [&](const ReferenceColumn& one) {
    return !has_convention(one.column) || (joint && one.column.owner != *joint);
  });
  return part;
}

std::vector<ReferenceRow> rows_in(const Standard& standard, Reference as_named, const Conventions& conventions) {
  as_named.conventions = conventions;
  return judge_rows(re_expressed(standard, conventions), in_stated_convention(standard.model, as_named)).rows;
}

/// A convention without the words that the names of the columns say already.
Convention in_few_words(const Reference& as_named, const Convention& whole) {
  const auto is_same = [&](const Convention& less) {
    if (re_expression_of(less) != re_expression_of(whole)) return false;
    return std::all_of(as_named.columns.begin(), as_named.columns.end(), [&](const ReferenceColumn& said) {
      const Column one = in_convention(said.column, less);
      const Column other = in_convention(said.column, whole);
      return one.field == other.field && one.side == other.side &&
             sign_in(said.column, less) == sign_in(said.column, whole);
    });
  };
  Convention few = whole;
  for (std::size_t k = 0; k < few.size(); ++k) {
    Convention less = few;
    less[k].reset();
    if (is_same(less)) few = less;
  }
  return few;
}

/// Whether a header with these lines holds all of another one.
bool holds_all(const std::vector<std::string>& lines, const std::vector<std::string>& others) {
  return std::all_of(others.begin(), others.end(), [&](const std::string& line) {
    return std::find(lines.begin(), lines.end(), line) != lines.end();
  });
}

/// All conventions for these columns. A word is left to the names of the columns where they say different things by it,
/// as where a table has both sides of a joint.
std::vector<Convention> conventions_for(const Reference& as_named) {
  const auto names_differ = [&](const auto& said) {
    const auto says = [&](const ReferenceColumn& one) { return said(one.column); };
    return std::any_of(as_named.columns.begin(), as_named.columns.end(), says) &&
           !std::all_of(as_named.columns.begin(), as_named.columns.end(), says);
  };
  const auto is_of = [](Field one, Field other) {
    return [one, other](const Column& column) { return column.field == one || column.field == other; };
  };
  std::vector<ConventionWord> left;
  if (names_differ([](const Column& column) { return column.side == Side::parent; })) {
    left.push_back(ConventionWord::side);
  }
  if (names_differ(is_of(Field::reaction_global, Field::total_global))) left.push_back(ConventionWord::axes);
  if (names_differ(is_of(Field::total, Field::total_global))) left.push_back(ConventionWord::driver);
  std::vector<Convention> all = all_conventions();
  for (const ConventionWord word : left) {
    const auto place = static_cast<std::size_t>(word);
    std::erase_if(all, [place](const Convention& one) { return one[place] != 0; });
    for (Convention& one : all) one[place].reset();
  }
  return all;
}

/// Conventions in which no column is wrong, and their lines in a header; those of few lines first, and none that says
/// more than another one.
using Fitting = std::vector<std::pair<Convention, std::vector<std::string>>>;
Fitting fitting(const Standard& standard, const Reference& as_named, const std::string& joint) {
  Fitting found;
  for (const Convention& convention : conventions_for(as_named)) {
    const std::vector<ReferenceRow> rows = rows_in(standard, as_named, {{"", convention}});
    const auto has = [&](ReferenceWord word) {
      return std::any_of(rows.begin(), rows.end(), [word](const ReferenceRow& row) { return row.word == word; });
    };
    if (has(ReferenceWord::wrong) || !has(ReferenceWord::equal)) continue;
    found.emplace_back(convention, header_lines(in_few_words(as_named, convention), joint));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  Fitting least;
  for (const auto& one : found) {
    const bool says_more =
        std::any_of(least.begin(), least.end(), [&](const auto& other) { return holds_all(one.second, other.second); });
    if (!says_more) least.push_back(one);
  }
  return least;
}

/// "equal in another convention: `# side = parent`, or `# axes = world` and `# sign = opposite`".
std::string describe(const Fitting& found) {
  std::vector<std::string> texts;
  for (const auto& [convention, lines] : found) {
    texts.push_back(lines.empty() ? "no line of a convention" : fmt::format("`{}`", fmt::join(lines, "` and `")));
  }
  return fmt::format("{}: {}", to_string(ReferenceWord::other_convention), fmt::join(texts, ", or "));
}

/// Joints that have a wrong row.
std::set<int> wrong_joints(const Reference& as_named, const std::vector<ReferenceRow>& rows) {
  std::set<int> joints;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Column& column = as_named.columns[k].column;
    if (has_convention(column) && rows[k].word == ReferenceWord::wrong) joints.insert(column.owner);
  }
  return joints;
}

}  // namespace

Reference in_stated_convention(const Model& model, const Reference& as_named) {
  Reference told = as_named;
  for (ReferenceColumn& column : told.columns) {
    if (!has_convention(column.column)) continue;
    const std::string& joint = model.joints.at(static_cast<std::size_t>(column.column.owner)).name;
    const Convention convention = stated_of(joint, as_named.conventions);
    for (double& value : column.values) value *= sign_in(column.column, convention);
    column.column = in_convention(column.column, convention);
    column.is_re_expressed = needs_re_expression(convention);
  }
  return told;
}

void find_conventions(const Standard& standard, const Reference& as_named, Verdict& verdict) {
  const std::set<int> joints = wrong_joints(as_named, verdict.references);
  if (joints.empty()) return;
  const auto name_of = [&](int joint) { return standard.model.joints.at(static_cast<std::size_t>(joint)).name; };
  const auto tell = [&](const std::string& of, const Fitting& found) {
    verdict.findings.push_back({fmt::format("reference: {} {}", of, describe(found)),
                                fmt::format("reference: {}; state that at its head", verdict.reference_file)});
  };
  Conventions conventions = as_named.conventions;
  std::map<int, Fitting> of_joints;
  const Fitting of_all = fitting(standard, with_conventions(as_named, {}), "");
  if (!of_all.empty()) {
    conventions = {{"", of_all.front().first}};
    tell("all joints are", of_all);
  } else {
    for (const int joint : joints) {
      Fitting found = fitting(standard, with_conventions(as_named, joint), name_of(joint));
      if (found.empty()) continue;
      conventions[name_of(joint)] = found.front().first;
      of_joints[joint] = std::move(found);
    }
    if (of_joints.empty()) return;
  }
  const std::vector<ReferenceRow> told = rows_in(standard, as_named, conventions);
  const std::set<int> still_wrong = wrong_joints(as_named, told);  // self-stresses join what joints are told
  for (const auto& [joint, found] : of_joints) {
    if (!still_wrong.contains(joint)) tell("joint " + name_of(joint) + " is", found);
  }
  for (std::size_t k = 0; k < told.size(); ++k) {
    const Column& column = as_named.columns[k].column;
    ReferenceRow& row = verdict.references[k];
    if (!has_convention(column) || row.word != ReferenceWord::wrong || still_wrong.contains(column.owner)) continue;
    row.word = told[k].word == ReferenceWord::equal ? ReferenceWord::other_convention : told[k].word;
    row.hint = "";
  }
}

}  // namespace concord::compare
