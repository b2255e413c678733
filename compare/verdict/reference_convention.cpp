#include "compare/verdict/reference_convention.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compare/quantities/convention.h"

namespace concord::compare {

namespace {

/// What is stated of a column's joint, and, where that says nothing, of all.
Convention stated_of(const Model& model, const Column& column, const Conventions& stated) {
  const auto of = [&](const std::string& joint) {
    const auto found = stated.find(joint);
    return found == stated.end() ? Convention() : found->second;
  };
  Convention own = of(model.joints.at(static_cast<std::size_t>(column.owner)).name);
  const Convention all = of("");
  if (!own.side) own.side = all.side;
  if (!own.in_world_axes) own.in_world_axes = all.in_world_axes;
  if (!own.with_driver) own.with_driver = all.with_driver;
  if (!own.opposite) own.opposite = all.opposite;
  return own;
}

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
  return judge_rows(standard, in_stated_convention(standard.model, as_named)).rows;
}

/// A convention without the words that the names of the columns say already.
Convention in_few_words(const Reference& as_named, const Convention& whole) {
  Convention few = whole;
  const auto drop = [&](auto Convention::*word) {
    Convention less = few;
    less.*word = {};
    const bool is_same =
        std::all_of(as_named.columns.begin(), as_named.columns.end(), [&](const ReferenceColumn& said) {
          const Column one = in_convention(said.column, less);
          const Column other = in_convention(said.column, whole);
          return one.field == other.field && one.side == other.side &&
                 sign_in(said.column, less) == sign_in(said.column, whole);
        });
    if (is_same) few = less;
  };
  drop(&Convention::side);
  drop(&Convention::in_world_axes);
  drop(&Convention::with_driver);
  drop(&Convention::opposite);
  return few;
}

/// Conventions in which no column is wrong, and their lines in a header; those of few lines first.
using Fitting = std::vector<std::pair<Convention, std::vector<std::string>>>;
Fitting fitting(const Standard& standard, const Reference& as_named, const std::string& joint) {
  Fitting found;
  for (const Convention& convention : all_conventions()) {
    const std::vector<ReferenceRow> rows = rows_in(standard, as_named, {{"", convention}});
    const auto has = [&](ReferenceWord word) {
      return std::any_of(rows.begin(), rows.end(), [word](const ReferenceRow& row) { return row.word == word; });
    };
    if (has(ReferenceWord::wrong) || !has(ReferenceWord::equal)) continue;
    found.emplace_back(convention, header_lines(in_few_words(as_named, convention), joint));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  return found;
}

/// "equal in another convention: `# side = parent`, or `# axes = world` and `# sign = opposite`".
std::string describe(const Fitting& found) {
  std::vector<std::string> texts;
  for (const auto& [convention, lines] : found) {
    texts.push_back(lines.empty() ? "no line of a convention" : fmt::format("`{}`", fmt::join(lines, "` and `")));
  }
  return fmt::format("{}: {}", to_string(ReferenceWord::other_convention), fmt::join(texts, ", or "));
}

/// The conventions of one joint, or, with "", of all joints, and the finding that tells them; nothing if none fits.
bool search(const Standard& standard, const Reference& part, const std::string& joint, Conventions& conventions,
            Verdict& verdict) {
  const Fitting found = fitting(standard, part, joint);
  if (found.empty()) return false;
  conventions[joint] = found.front().first;
  verdict.findings.push_back(
      {fmt::format("reference: {} {}", joint.empty() ? "all joints are" : "joint " + joint + " is", describe(found)),
       fmt::format("reference: {}; state that in a line at its head", verdict.reference_file)});
  return true;
}

}  // namespace

Reference in_stated_convention(const Model& model, const Reference& as_named) {
  Reference told = as_named;
  for (ReferenceColumn& column : told.columns) {
    if (!has_convention(column.column)) continue;
    const Convention convention = stated_of(model, column.column, as_named.conventions);
    for (double& value : column.values) value *= sign_in(column.column, convention);
    column.column = in_convention(column.column, convention);
  }
  return told;
}

void find_conventions(const Standard& standard, const Reference& as_named, Verdict& verdict) {
  std::set<int> joints;
  for (std::size_t k = 0; k < as_named.columns.size(); ++k) {
    const Column& column = as_named.columns[k].column;
    if (has_convention(column) && verdict.references[k].word == ReferenceWord::wrong) joints.insert(column.owner);
  }
  if (joints.empty()) return;
  Conventions conventions;
  if (!search(standard, with_conventions(as_named, {}), "", conventions, verdict)) {
    conventions = as_named.conventions;
    bool is_found = false;
    for (const int joint : joints) {
      const std::string& name = standard.model.joints.at(static_cast<std::size_t>(joint)).name;
      is_found = search(standard, with_conventions(as_named, joint), name, conventions, verdict) || is_found;
    }
    if (!is_found) return;
  }
  const std::vector<ReferenceRow> told = rows_in(standard, as_named, conventions);
  for (std::size_t k = 0; k < told.size(); ++k) {
    ReferenceRow& row = verdict.references[k];
    if (row.word != ReferenceWord::wrong || told[k].word == ReferenceWord::wrong) continue;
    row.word = told[k].word == ReferenceWord::equal ? ReferenceWord::other_convention : told[k].word;
    row.hint = "";
  }
}

}  // namespace concord::compare
