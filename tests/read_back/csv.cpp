#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/read_back/expected.h"

namespace concord::read_back {

namespace {

/// A column that a file must have, with its numbers from the first row to the last.
struct ExpectedColumn {
  std::string header;
  std::vector<double> numbers;
};

/// Comma-separated values, split by hand.
struct CsvFile {
  std::vector<std::string> comments;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields{""};
  bool is_quoted = false;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (line[k] == '"' && is_quoted && k + 1 < line.size() && line[k + 1] == '"') {
      fields.back() += line[++k];
    } else if (line[k] == '"') {
      is_quoted = !is_quoted;
    } else if (line[k] == ',' && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back() += line[k];
    }
  }
  return fields;
}

CsvFile read_csv(const std::filesystem::path& path) {
  CsvFile file;
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("#")) {
      file.comments.push_back(line);
    } else if (file.header.empty()) {
      file.header = split(line);
    } else {
      file.rows.push_back(split(line));
    }
  }
  return file;
}

/// The number that a cell holds, written in full; nothing else may stand there.
bool holds(const std::string& cell, double number) {
  char* end = nullptr;
  const double read = std::strtod(cell.c_str(), &end);
  return !cell.empty() && *end == '\0' && is_same(read, number);
}

void compare_column(const CsvFile& file, std::size_t place, const ExpectedColumn& column, Complaints& complaints) {
  for (std::size_t k = 0; k < std::min(file.rows.size(), column.numbers.size()); ++k) {
    const std::string cell = place < file.rows[k].size() ? file.rows[k][place] : "";
    if (holds(cell, column.numbers[k])) continue;
    const std::size_t line = file.comments.size() + 2 + k;
    return complaints.add(
        fmt::format("{}: '{}' in line {}, the run has {}", column.header, cell, line, column.numbers[k]));
  }
}

/// Every column that is expected, no other one, and a row for each of its numbers.
void compare_columns(const CsvFile& file, const std::vector<ExpectedColumn>& expected, Complaints& complaints) {
  const std::size_t rows = expected.front().numbers.size();
  complaints.expect(file.rows.size() == rows, fmt::format("{} rows, the run has {}", file.rows.size(), rows));
  complaints.expect(!file.header.empty() && file.header.front() == expected.front().header,
                    fmt::format("the first column is not {}", expected.front().header));
  for (const std::vector<std::string>& row : file.rows) {
    if (row.size() == file.header.size()) continue;
    complaints.add(fmt::format("{} cells in a row, {} columns", row.size(), file.header.size()));
    break;
  }
  std::map<std::string, std::size_t> places;
  for (std::size_t place = 0; place < file.header.size(); ++place) {
    complaints.expect(places.emplace(file.header[place], place).second,
                      fmt::format("{}: stands there twice", file.header[place]));
  }
  for (const ExpectedColumn& column : expected) {
    const auto found = places.find(column.header);
    if (found == places.end()) {
      complaints.add(fmt::format("{}: is missing", column.header));
      continue;
    }
    compare_column(file, found->second, column, complaints);
    places.erase(found);
  }
  for (const auto& [header, place] : places) complaints.add(fmt::format("{}: is no number of the run", header));
}

/// Columns of one run, filled sample by sample.
class Table {
 public:
  explicit Table(const Expected& expected) : expected_(expected) {
    add("t [s]", [&](std::size_t k) { return expected.sample(k).state.t; });
  }

  template <class Number>
  void add(const std::string& header, const Number& number) {
    ExpectedColumn column{header, {}};
    for (std::size_t k = 0; k < expected_.samples(); ++k) column.numbers.push_back(number(k));
    columns.push_back(std::move(column));
  }

  std::vector<ExpectedColumn> columns;

 private:
  const Expected& expected_;
};

std::vector<ExpectedColumn> motion_table(const Expected& expected) {
  Table table(expected);
  const Model& model = expected.run().model;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const std::string& name = model.bodies[i].name;
    const auto state = [&, i](std::size_t k) -> const BodyState& { return expected.sample(k).state.bodies.at(i); };
    const auto rate = [&, i](std::size_t k) -> const BodyAcceleration& {
      return expected.sample(k).evaluation.bodies.at(i);
    };
    for (int c = 0; c < 4; ++c) table.add(fmt::format("{}.e{} [1]", name, c), [&](auto k) { return state(k).p(c); });
    for (int c = 0; c < 3; ++c) {
      const char axis = "xyz"[c];
      table.add(fmt::format("{}.{} [m]", name, axis), [&](auto k) { return state(k).r(c); });
      table.add(fmt::format("{}.v_{} [m/s]", name, axis), [&](auto k) { return state(k).v(c); });
      table.add(fmt::format("{}.omega_{} [rad/s]", name, axis), [&](auto k) { return state(k).omega(c); });
      table.add(fmt::format("{}.vdot_{} [m/s2]", name, axis), [&](auto k) { return rate(k).vdot(c); });
      table.add(fmt::format("{}.omegadot_{} [rad/s2]", name, axis), [&](auto k) { return rate(k).omegadot(c); });
    }
    for (int m = 0; m < model.bodies[i].n_modes(); ++m) {
      table.add(fmt::format("{}.a_{} [1]", name, m + 1), [&](auto k) { return state(k).a(m); });
      table.add(fmt::format("{}.adot_{} [1/s]", name, m + 1), [&](auto k) { return state(k).adot(m); });
      table.add(fmt::format("{}.addot_{} [1/s2]", name, m + 1), [&](auto k) { return rate(k).addot(m); });
    }
  }
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const std::vector<std::string> units = units_of(model.joints[j]).q;
    for (std::size_t c = 0; c < units.size(); ++c) {
      table.add(fmt::format("{}.q_{} [{}]", model.joints[j].name, c + 1, units[c]),
                [&](auto k) { return expected.sample(k).state.q.at(j)(static_cast<int>(c)); });
    }
  }
  return std::move(table.columns);
}

/// The columns of reactions, and in `comments` the lines that name those which are not unique.
std::vector<ExpectedColumn> reaction_table(const Expected& expected, std::set<std::string>& comments) {
  Table table(expected);
  Table own(expected);
  own.columns.clear();
  std::map<std::size_t, std::string> open;  // names by the number of samples
  const auto add = [&](const std::string& name, const std::string& unit, const auto& known, const auto& solvers_own) {
    const std::string header = fmt::format("{} [{}]", name, unit);
    table.add(header, known);
    const std::vector<double>& numbers = table.columns.back().numbers;
    const auto count = static_cast<std::size_t>(
        std::count_if(numbers.begin(), numbers.end(), [](double number) { return std::isnan(number); }));
    if (count == 0) return;
    own.add("any_" + header, solvers_own);
    open[count] += (open[count].empty() ? "" : ", ") + name;
  };
  const Model& model = expected.run().model;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    for (std::size_t side = 0; side < 2; ++side) {
      for (std::size_t c = 0; c < 6; ++c) {
        add(
            fmt::format("{}.{}.{}", model.joints[j].name, kSides[side], kComponents[c]), unit_of_component(c),
            [&](auto k) { return expected.known(Which::reaction, Axes::joint, k, j, side, c); },
            [&](auto k) { return expected.own(Which::reaction, Axes::joint, k, j, side, c); });
      }
    }
    const std::vector<std::string> units = units_of(model.joints[j]).tau;
    for (std::size_t c = 0; c < units.size(); ++c) {
      add(
          fmt::format("{}.tau_{}", model.joints[j].name, c + 1), units[c],
          [&](auto k) { return expected.known_tau(k, j, c); },
          [&](auto k) { return expected.sample(k).evaluation.joints.at(j).tau(static_cast<int>(c)); });
    }
    const std::vector<std::array<bool, 4>> actors = actors_of(model.joints[j]);
    for (std::size_t c = 0; c < units.size(); ++c) {
      for (std::size_t actor = 0; actor < 4; ++actor) {
        if (!actors[c][actor]) continue;
        add(
            fmt::format("{}.{}_{}", model.joints[j].name, kActorNames[actor], c + 1), units[c],
            [&](auto k) { return expected.known_share(k, j, c, actor); },
            [&](auto k) { return expected.sample(k).evaluation.joints.at(j).shares[actor](static_cast<int>(c)); });
      }
    }
  }
  for (const auto& [count, names] : open) {
    comments.insert(fmt::format("# not unique in {} of {} samples: {}", count, expected.samples(), names));
  }
  if (!open.empty())
    comments.insert("# there nan stands, and in the column any_... the solver's own value, one of many");
  std::move(own.columns.begin(), own.columns.end(), std::back_inserter(table.columns));
  return std::move(table.columns);
}

std::vector<ExpectedColumn> element_table(const Expected& expected) {
  Table table(expected);
  const Model& model = expected.run().model;
  for (std::size_t e = 0; e < model.elements.size(); ++e) {
    for (std::size_t side = 0; side < 2; ++side) {
      if (!has_end(model.elements[e], side)) continue;
      for (std::size_t c = 0; c < 6; ++c) {
        table.add(
            fmt::format("{}.{}.{} [{}]", model.elements[e].name, kSides[side], kComponents[c], unit_of_component(c)),
            [&](auto k) {
              const Wrench& wrench = expected.sample(k).evaluation.elements.at(e).on.at(side).in_C;
              return c < 3 ? wrench.force(static_cast<int>(c)) : wrench.torque(static_cast<int>(c) - 3);
            });
      }
    }
  }
  return std::move(table.columns);
}

void append(std::vector<std::string>& all, const std::vector<std::string>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

std::vector<std::string> unlike_csv(const std::filesystem::path& path, const std::vector<ExpectedColumn>& columns,
                                    const std::set<std::string>& comments = {}) {
  Complaints complaints(path.filename().string());
  const CsvFile file = read_csv(path);
  compare_columns(file, columns, complaints);
  complaints.expect(std::set<std::string>(file.comments.begin(), file.comments.end()) == comments,
                    "the comments do not name what is not unique");
  return complaints.all();
}

}  // namespace

std::vector<std::string> unlike_csv_files(const std::filesystem::path& folder, const Expected& expected) {
  const Run& run = expected.run();
  const auto path = [&](const char* ending) {
    return folder / fmt::format("{}.{}.{}.csv", run.model.name, run.solver, ending);
  };
  std::set<std::string> comments;
  const std::vector<ExpectedColumn> reactions = reaction_table(expected, comments);
  std::vector<std::string> all = unlike_csv(path("motion"), motion_table(expected));
  append(all, unlike_csv(path("reactions"), reactions, comments));
  if (!run.model.elements.empty()) append(all, unlike_csv(path("elements"), element_table(expected)));
  if (run.model.elements.empty() && exists(path("elements"))) all.emplace_back("elements.csv of no force element");
  return all;
}

std::vector<std::string> unlike_modes(const std::filesystem::path& file, const Model& model,
                                      const compare::analyses::Linearization& found) {
  std::vector<ExpectedColumn> columns;
  const auto add = [&](const std::string& header, const auto& number) {
    columns.push_back({header, {}});
    for (std::size_t k = 0; k < found.modes.size(); ++k) columns.back().numbers.push_back(number(k));
  };
  constexpr double kTwoPi = 6.283185307179586;
  const auto eigenvalue = [&](std::size_t k) { return found.modes[k].eigenvalue; };
  add("mode", [](std::size_t k) { return static_cast<double>(k + 1); });
  add("eigenvalue.re [1/s]", [&](std::size_t k) { return eigenvalue(k).real(); });
  add("eigenvalue.im [1/s]", [&](std::size_t k) { return eigenvalue(k).imag(); });
  add("frequency [Hz]", [&](std::size_t k) { return std::abs(eigenvalue(k)) / kTwoPi; });
  add("damping_ratio",
      [&](std::size_t k) { return found.modes[k].is_free ? 0.0 : -eigenvalue(k).real() / std::abs(eigenvalue(k)); });
  add("free", [&](std::size_t k) { return found.modes[k].is_free ? 1.0 : 0.0; });
  int place = 0;
  const auto add_complex = [&](const std::string& header) {
    add("re " + header, [&](std::size_t k) { return found.modes[k].shape(place).real(); });
    add("im " + header, [&](std::size_t k) { return found.modes[k].shape(place).imag(); });
    ++place;
  };
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const std::string& name = model.bodies[i].name;
    for (const char axis : {'x', 'y', 'z'}) add_complex(fmt::format("{}.v_{} [m/s]", name, axis));
    for (const char axis : {'x', 'y', 'z'}) add_complex(fmt::format("{}.omega_{} [rad/s]", name, axis));
    for (int m = 1; m <= model.bodies[i].n_modes(); ++m) add_complex(fmt::format("{}.adot_{} [1/s]", name, m));
  }
  return unlike_csv(file, columns);
}

}  // namespace concord::read_back
