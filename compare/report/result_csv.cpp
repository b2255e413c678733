#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compare/quantities/columns.h"
#include "compare/report/files.h"
#include "compare/report/result_files.h"
#include "compare/report/told_axes.h"
#include "compare/resolution/unique_part.h"

namespace concord::compare {

namespace {

std::string csv_field(const std::string& field) {
  if (field.find_first_of(",\"\n") == std::string::npos) return field;
  std::string result = "\"";
  for (const char c : field) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + '"';
}

/// Columns of numbers, and the run from which they are taken.
struct ColumnsOf {
  std::vector<Column> columns;
  const Trajectory* run;
};

/// Comma-separated values: a header, then rows of numbers that read back exactly, the time first.
void write_csv(const std::filesystem::path& path, const std::vector<ColumnsOf>& parts, std::string text = "") {
  text += "t [s]";
  for (const ColumnsOf& part : parts) {
    for (const Column& column : part.columns) text += ',' + csv_field(fmt::format("{} [{}]", column.name, column.unit));
  }
  text += '\n';
  for (std::size_t k = 0; k < parts.front().run->samples.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{}", parts.front().run->samples[k].state.t);
    for (const ColumnsOf& part : parts) {
      const Sample& sample = part.run->samples[k];
      for (const Column& column : part.columns) {
        fmt::format_to(std::back_inserter(text), ",{}", value_of(column, sample));
      }
    }
    text += '\n';
  }
  write_file(path, text);
}

/// Columns of wrenches that are told in the axes of a body say so: "A.child.in_crank.F_x".
std::vector<Column> with_axes(std::vector<Column> columns, const Model& model, std::optional<int> axes) {
  for (Column& column : columns) {
    const bool is_wrench = column.field == Field::reaction || column.field == Field::element;
    if (is_wrench) column.name.insert(column.name.rfind('.') + 1, prefix_of(model, axes));
  }
  return columns;
}

/// In how many samples a column holds NaN.
std::ptrdiff_t open_samples(const Column& column, const Trajectory& known) {
  return std::count_if(known.samples.begin(), known.samples.end(),
                       [&](const Sample& sample) { return std::isnan(value_of(column, sample)); });
}

}  // namespace

void write_motion_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory) {
  write_csv(path, {{motion_columns(model), &trajectory}});
}

void write_reaction_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory,
                        const Mask* unique, std::optional<int> axes) {
  std::vector<Column> columns = with_axes(reaction_columns(model), model, axes);
  std::optional<Trajectory> known = unique != nullptr ? unique_part(model, trajectory, *unique) : std::nullopt;
  if (known && axes) known = told_run(model, std::move(*known), *axes);
  const std::optional<Trajectory> told = axes ? std::optional(told_run(model, trajectory, *axes)) : std::nullopt;
  const Trajectory& given = told ? *told : trajectory;
  if (!known) return write_csv(path, {{std::move(columns), &given}});
  std::vector<Column> own;
  std::map<std::ptrdiff_t, std::string> names;  // of columns that are not unique, by the number of samples
  for (const Column& column : columns) {
    const std::ptrdiff_t count = open_samples(column, *known);
    if (count == 0) continue;
    own.push_back(own_column(column));
    names[count] += (names[count].empty() ? "" : ", ") + column.name;
  }
  std::string text;
  for (const auto& [count, list] : names) {
    text += fmt::format("# not unique in {} of {} samples: {}\n", count, known->samples.size(), list);
  }
  if (!own.empty()) text += "# there nan stands, and in the column any_... the solver's own value, one of many\n";
  write_csv(path, {{std::move(columns), &*known}, {std::move(own), &given}}, std::move(text));
}

void write_element_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory,
                       std::optional<int> axes) {
  const std::optional<Trajectory> told = axes ? std::optional(told_run(model, trajectory, *axes)) : std::nullopt;
  write_csv(path, {{with_axes(element_columns(model), model, axes), told ? &*told : &trajectory}});
}

}  // namespace concord::compare
