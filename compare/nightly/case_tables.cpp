#include "compare/nightly/case_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace concord::compare::nightly {

std::optional<std::vector<std::string>> read_texts(const TableReader& table, std::string_view key) {
  if (!table.has(key)) return std::nullopt;
  const toml::array* list = table.node(key)->as_array();
  std::vector<std::string> texts;
  for (const toml::node& entry : list != nullptr ? *list : toml::array()) {
    if (entry.is_string()) texts.push_back(**entry.as_string());
  }
  if (list != nullptr && texts.size() == list->size() && !texts.empty()) return texts;
  table.complain(key, fmt::format("'{}' must be a list of one or more strings", key));
  return std::nullopt;
}

KnownKeys keys_of(const toml::table& table) {
  KnownKeys keys;
  for (const auto& [key, value] : table) keys.push_back(key.str());
  return keys;
}

std::optional<KnownRed> read_known_red(const TableReader& outer) {
  const toml::table* found = outer.table("known_red");
  if (found == nullptr) return std::nullopt;
  const TableReader table(*found, outer.title() + ", known_red", {"reason", "until"}, outer.reading());
  if (!table.require({"reason", "until"})) return std::nullopt;
  KnownRed known;
  known.reason = table.text("reason").value_or("");
  if (known.reason.empty()) table.complain("reason", "a known red case needs a reason");
  if (const toml::date* day = table.node("until")->is_date() ? &table.node("until")->as_date()->get() : nullptr) {
    known.until = fmt::format("{:04}-{:02}-{:02}", day->year, day->month, day->day);
  } else {
    table.complain("until", "'until' must be a date without quotes, such as 2026-12-31");
  }
  return known;
}

std::vector<NeedOverride> read_case_needs(const TableReader& outer) {
  std::vector<NeedOverride> needs;
  for (const toml::table* found : outer.tables("need")) {
    const TableReader table(*found, outer.title() + ", need",
                            {"joint", "element", "body", "component", "same_state", "same_run", "refined", "because"},
                            outer.reading());
    NeedOverride& need = needs.emplace_back();
    need.where = table.where();
    need.joint = table.text("joint").value_or("");
    need.element = table.text("element").value_or("");
    need.body = table.text("body").value_or("");
    need.component = table.text("component").value_or("");
    need.because = table.text("because").value_or("");
    need.same_state = table.number_not_negative("same_state");
    need.same_run = table.number_not_negative("same_run");
    need.refined = table.number_not_negative("refined");
  }
  return needs;
}

std::vector<analyses::AskedAcceleration> read_accelerations(const TableReader& outer) {
  std::vector<analyses::AskedAcceleration> asked;
  const toml::table* found = outer.table("accelerations");
  if (found == nullptr) return asked;
  const KnownKeys names = keys_of(*found);
  const TableReader table(*found, outer.title() + ", accelerations", names, outer.reading());
  for (const std::string_view name : names) {
    const std::size_t dot = name.rfind('.');
    if (dot == std::string_view::npos) {
      table.complain(name, fmt::format("'{}' must be \"joint.coordinate\", such as \"hinge.turn_z\"", name));
    } else if (const auto value = table.number(name)) {
      asked.push_back({std::string(name.substr(0, dot)), std::string(name.substr(dot + 1)), *value, table.where(name)});
    }
  }
  return asked;
}

namespace {

std::optional<StartDraws> read_start(const TableReader& outer) {
  const toml::table* found = outer.table("start");
  if (found == nullptr) return std::nullopt;
  const TableReader table(*found, outer.title() + ", start",
                          {"seed", "count", "turn", "slide", "turn_speed", "slide_speed"}, outer.reading());
  if (!table.require({"seed", "count"})) return std::nullopt;
  StartDraws draws;
  draws.first.seed = static_cast<std::uint64_t>(table.count("seed", 0).value_or(0));
  draws.count = table.count("count", 1, 100000).value_or(1);
  draws.first.turn = table.number_not_negative("turn").value_or(0.0);
  draws.first.slide = table.number_not_negative("slide").value_or(0.0);
  draws.first.turn_speed = table.number_not_negative("turn_speed").value_or(0.0);
  draws.first.slide_speed = table.number_not_negative("slide_speed").value_or(0.0);
  if (!table.has("turn") && !table.has("slide") && !table.has("turn_speed") && !table.has("slide_speed")) {
    table.complain("says nothing: give 'turn', 'slide', 'turn_speed' or 'slide_speed'");
  }
  return draws;
}

/// The numbers of a list that is swept: not none, which would leave the sweep out, and each once.
std::optional<std::vector<double>> read_swept(const TableReader& table, std::string_view key) {
  const auto values = table.numbers(key);
  if (!values) return std::nullopt;
  if (values->empty()) table.complain(key, fmt::format("'{}' is an empty list: it sweeps nothing", key));
  std::vector<double> once;
  for (const double value : *values) {
    if (std::find(once.begin(), once.end(), value) == once.end()) {
      once.push_back(value);
    } else {
      table.complain(key, fmt::format("'{}' sweeps {:g} twice", key, value));
    }
  }
  return once;
}

void read_swept_parameters(const TableReader& outer, Sweep& sweep) {
  const toml::table* found = outer.table("parameters");
  if (found == nullptr) return;
  const KnownKeys names = keys_of(*found);
  const TableReader table(*found, outer.title() + ", parameters", names, outer.reading());
  for (const std::string_view name : names) {
    if (auto values = read_swept(table, name)) sweep.parameters.emplace_back(name, std::move(*values));
  }
}

void read_cuts(const TableReader& outer, Sweep& sweep) {
  const toml::table* found = outer.table("cut");
  if (found == nullptr) return;
  const KnownKeys names = keys_of(*found);
  const TableReader table(*found, outer.title() + ", cut", names, outer.reading());
  for (const std::string_view name : names) {
    if (auto joints = read_texts(table, name)) sweep.cuts.emplace_back(name, std::move(*joints));
  }
}

void read_integrators(const TableReader& table, Sweep& sweep) {
  if (!table.has("integrators")) return;
  const toml::array* list = table.node("integrators")->as_array();
  for (const toml::node& entry : list != nullptr ? *list : toml::array()) {
    const toml::array* pair = entry.as_array();
    const bool is_pair = pair != nullptr && pair->size() == 2 && pair->get(0)->is_string() && pair->get(1)->is_string();
    if (!is_pair) continue;
    const std::array<std::string, 2> both{**pair->get(0)->as_string(), **pair->get(1)->as_string()};
    if (std::find(sweep.integrators.begin(), sweep.integrators.end(), both) != sweep.integrators.end()) {
      return table.complain("integrators", fmt::format("'integrators' sweeps {} and {} twice", both[0], both[1]));
    }
    sweep.integrators.push_back(both);
  }
  if (list != nullptr && !list->empty() && sweep.integrators.size() == list->size()) return;
  table.complain("integrators", "'integrators' must be a list of pairs: the Cartesian solver's, the relative one's");
}

}  // namespace

Sweep read_sweep(const TableReader& outer) {
  Sweep sweep;
  const toml::table* found = outer.table("sweep");
  if (found == nullptr) return sweep;
  const TableReader table(*found, outer.title() + ", sweep", {"parameters", "cut", "integrators", "rtol", "start"},
                          outer.reading());
  read_swept_parameters(table, sweep);
  read_cuts(table, sweep);
  read_integrators(table, sweep);
  sweep.rtol = read_swept(table, "rtol").value_or(std::vector<double>());
  for (const double rtol : sweep.rtol) {
    if (rtol >= kTightestTolerance && rtol <= kLoosestTolerance) continue;
    table.complain("rtol", fmt::format("tolerances must lie between {:g} and {:g}, found {:g}", kTightestTolerance,
                                       kLoosestTolerance, rtol));
  }
  sweep.start = read_start(table);
  return sweep;
}

}  // namespace concord::compare::nightly
