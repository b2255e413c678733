#include "compare/verdict/reference_convention.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
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

using Indices = std::vector<std::size_t>;

/// The search among one set of columns, of all joints or of one.
struct Search {
  const RunsAtTimes& runs;
  const Reference& as_named;
  const Trajectory& known;

  [[nodiscard]] bool fits(std::size_t column, const Convention& convention) const {
    const ReferenceColumn& said = as_named.columns[column];
    const Column other = in_convention(said.column, convention);
    const double sign = sign_in(said.column, convention);
    const double allowed = runs.verdict.references[column].allowed;
    for (std::size_t k = 0; k < runs.samples.size(); ++k) {
      if (std::isnan(said.values[k]) || std::isnan(value_of(other, known.samples[runs.samples[k]]))) continue;
      for (std::size_t who = 0; who < 2; ++who) {
        if (!(std::abs(value_of(other, runs.sample(who, k)) - sign * said.values[k]) <= allowed)) return false;
      }
    }
    return true;
  }

  [[nodiscard]] bool fit(const Indices& columns, const Convention& convention) const {
    return std::all_of(columns.begin(), columns.end(), [&](std::size_t k) { return fits(k, convention); });
  }

  /// A convention without the words that the names of the columns say already.
  [[nodiscard]] Convention in_few_words(const Indices& columns, const Convention& whole) const {
    Convention few = whole;
    const auto drop = [&](auto Convention::*word) {
      Convention less = few;
      less.*word = {};
      const bool is_same = std::all_of(columns.begin(), columns.end(), [&](std::size_t k) {
        const Column& column = as_named.columns[k].column;
        const Column one = in_convention(column, less);
        const Column other = in_convention(column, whole);
        return one.field == other.field && one.side == other.side && sign_in(column, less) == sign_in(column, whole);
      });
      if (is_same) few = less;
    };
    drop(&Convention::side);
    drop(&Convention::in_world_axes);
    drop(&Convention::with_driver);
    drop(&Convention::opposite);
    return few;
  }

  /// The header lines of every convention that fits, those of few lines first: "`# side = parent`", "`# axes = world`
  /// and `# sign = opposite`".
  [[nodiscard]] std::vector<std::string> found(const Indices& columns, const std::string& joint) const {
    std::vector<std::vector<std::string>> all;
    for (const Convention& convention : all_conventions()) {
      if (!fit(columns, convention)) continue;
      all.push_back(header_lines(in_few_words(columns, convention), joint));
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    std::vector<std::string> texts;
    for (const std::vector<std::string>& lines : all) {
      texts.push_back(lines.empty() ? "no line of a convention" : fmt::format("`{}`", fmt::join(lines, "` and `")));
    }
    return texts;
  }
};

/// Tells conventions of a set of columns that fit; whether there is one.
bool tell(const std::vector<std::string>& found, const Indices& columns, const std::string& of, Verdict& verdict) {
  if (found.empty()) return false;
  const std::string said = fmt::format("equal in another convention: {}", fmt::join(found, ", or "));
  for (const std::size_t k : columns) {
    if (is_off(verdict.references[k])) verdict.references[k].hint = said;
  }
  verdict.notes.push_back(fmt::format("reference: {} {} when its header says so", of, said));
  return true;
}

}  // namespace

bool is_off(const ReferenceRow& row) { return row.is_judged && !row.agrees; }

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

bool find_conventions(const Model& model, const RunsAtTimes& runs, const Reference& as_named, const Trajectory& known,
                      Verdict& verdict) {
  Indices all;
  std::set<int> joints;
  bool others_agree = true;
  for (std::size_t k = 0; k < as_named.columns.size(); ++k) {
    const Column& column = as_named.columns[k].column;
    if (has_convention(column)) all.push_back(k);
    if (!is_off(verdict.references[k])) continue;
    if (has_convention(column)) joints.insert(column.owner);
    others_agree = others_agree && has_convention(column);
  }
  if (joints.empty()) return false;
  const Search search{runs, as_named, known};
  if (tell(search.found(all, ""), all, "all joints are", verdict)) return others_agree;
  for (const int joint : joints) {
    Indices own;
    std::copy_if(all.begin(), all.end(), std::back_inserter(own),
                 [&](std::size_t k) { return as_named.columns[k].column.owner == joint; });
    const std::string& name = model.joints.at(static_cast<std::size_t>(joint)).name;
    if (!tell(search.found(own, name), own, fmt::format("joint {} is", name), verdict)) others_agree = false;
  }
  return others_agree;
}

}  // namespace concord::compare
