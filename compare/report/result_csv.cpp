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
                        const Mask* unique) {
  std::vector<Column> columns = reaction_columns(model);
  const std::optional<Trajectory> known = unique != nullptr ? unique_part(model, trajectory, *unique) : std::nullopt;
  if (!known) return write_csv(path, {{std::move(columns), &trajectory}});
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
  write_csv(path, {{std::move(columns), &*known}, {std::move(own), &trajectory}}, std::move(text));
}

void write_element_csv(const std::filesystem::path& path, const Model& model, const Trajectory& trajectory) {
  write_csv(path, {{element_columns(model), &trajectory}});
}

}  // namespace concord::compare
