#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compare/audit/carried_components.h"
#include "compare/report/files.h"
#include "compare/report/result_files.h"
#include "compare/verdict/columns.h"
#include "compare/verdict/observe.h"

namespace concord::compare {

namespace {

std::string csv_field(const std::string& field) {
  if (field.find_first_of(",\"\n") == std::string::npos) return field;
  std::string result = "\"";
  for (const char c : field) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + '"';
}

/// Comment lines that name the columns which are not unique in some sample.
std::string not_unique_comments(const Model& model, const std::vector<Column>& columns, const Mask& unique) {
  const QuantityLayout layout(model);
  std::map<Eigen::Index, std::string> names;  // by the number of samples
  for (const Column& column : columns) {
    const std::optional<Quantity> quantity = quantity_of(column);
    if (!quantity) continue;
    const bool can_carry = quantity->kind != Kind::reaction ||
                           carries(*model.joints[quantity->owner].type, quantity->side, quantity->component);
    const auto& known = layout.quantities();
    if (!can_carry || std::find(known.begin(), known.end(), *quantity) == known.end()) continue;
    const Eigen::Index count = (!unique.row(layout.row_of(*quantity))).count();
    if (count > 0) names[count] += (names[count].empty() ? "" : ", ") + column.name;
  }
  std::string text;
  for (const auto& [count, list] : names) {
    text += fmt::format("# not unique in {} of {} samples: {}\n", count, unique.cols(), list);
  }
  return text;
}

/// Comma-separated values: a header, then rows of numbers that read back exactly, the time first.
void write_csv(const std::filesystem::path& path, const std::vector<Column>& columns, const Trajectory& trajectory,
               std::string text = "") {
  text += "t [s]";
  for (const Column& column : columns) text += ',' + csv_field(fmt::format("{} [{}]", column.name, column.unit));
  text += '\n';
  for (const Sample& sample : trajectory.samples) {
    fmt::format_to(std::back_inserter(text), "{}", sample.state.t);
    for (const Column& column : columns) fmt::format_to(std::back_inserter(text), ",{}", value_of(column, sample));
    text += '\n';
  }
  write_file(path, text);
}

}  // namespace

void write_motion_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory) {
  write_csv(path, motion_columns(model), trajectory);
}

void write_reaction_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory,
                        const Mask* unique) {
  const std::vector<Column> columns = reaction_columns(model);
  write_csv(path, columns, trajectory, unique != nullptr ? not_unique_comments(model, columns, *unique) : "");
}

void write_element_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory) {
  write_csv(path, element_columns(model), trajectory);
}

}  // namespace concord::compare
