#include "compare/nightly/case_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <initializer_list>
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

std::optional<TableReader> inner_table(const TableReader& outer, std::string_view key, const KnownKeys& known) {
  const toml::table* found = outer.table(key);
  if (found == nullptr) return std::nullopt;
  return TableReader(*found, fmt::format("{}, {}", outer.title(), key), known, outer.reading());
}

namespace {

using Works = std::vector<Work>;

/// A key and the kinds of work that it means something to.
struct KeyOfWork {
  std::string_view key;
  Works works;
};

Works together(std::initializer_list<Works> parts) {
  Works all;
  for (const Works& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

const std::vector<KeyOfWork>& keys_of_works() {
  static const Works any{Work::compare, Work::statics, Work::linearize, Work::kinematics,
                         Work::inverse, Work::joint,   Work::fuzz,      Work::invariance};
  static const Works wrenches{Work::compare, Work::statics, Work::linearize, Work::kinematics, Work::inverse};
  static const Works models = together({wrenches, {Work::invariance}});
  static const Works runs{Work::compare, Work::kinematics};
  static const std::vector<KeyOfWork> keys{
      {"name", any},
      {"work", any},
      {"seconds", any},
      {"megabytes", any},
      {"known_red", any},
      {"judge", any},
      {"models", models},
      {"except", models},
      {"parameters", models},
      {"cut", models},
      {"sweep", models},
      {"need", wrenches},
      {"until", together({runs, {Work::invariance}})},
      {"samples", runs},
      {"rtol", {Work::compare}},
      {"states", {Work::compare}},
      {"cartesian", {Work::compare}},
      {"relative", {Work::compare}},
      {"at", {Work::linearize}},
      {"accelerations", {Work::inverse}},
      {"joints", {Work::joint}},
      {"poses", {Work::joint}},
      {"seed", {Work::fuzz}},
      {"first", {Work::fuzz}},
      {"count", {Work::fuzz}},
      {"shares", {Work::fuzz}},
      {"style", {Work::fuzz}},
  };
  return keys;
}

bool is_for(const Works& works, Work work) { return std::find(works.begin(), works.end(), work) != works.end(); }

std::string words_of_refusal(std::string_view key, Work work, const Works& works) {
  std::vector<std::string> names;
  for (const Work one : works) names.push_back('"' + name_of(one) + '"');
  return fmt::format("'{}' means nothing to the work \"{}\", only to {}", key, name_of(work), fmt::join(names, ", "));
}

}  // namespace

KnownKeys case_keys() {
  KnownKeys keys;
  for (const KeyOfWork& one : keys_of_works()) keys.push_back(one.key);
  return keys;
}

void refuse_keys_without_meaning(const TableReader& table, Work work) {
  for (const auto& [key, works] : keys_of_works()) {
    if (table.has(key) && !is_for(works, work)) table.complain(key, words_of_refusal(key, work, works));
  }
  const toml::table* sweep = table.has("sweep") ? table.node("sweep")->as_table() : nullptr;
  if (sweep == nullptr || work == Work::compare) return;
  for (const std::string_view key : {"rtol", "integrators"}) {
    if (sweep->contains(key)) table.complain("sweep", words_of_refusal(key, work, {Work::compare}));
  }
}

std::optional<KnownRed> read_known_red(const TableReader& outer) {
  const auto table = inner_table(outer, "known_red", {"reason", "until"});
  if (!table || !table->require({"reason", "until"})) return std::nullopt;
  KnownRed known;
  known.reason = table->text("reason").value_or("");
  if (known.reason.empty()) table->complain("reason", "a known red case needs a reason");
  if (const toml::value<toml::date>* day = table->node("until")->as_date()) {
    known.until = fmt::format("{:04}-{:02}-{:02}", day->get().year, day->get().month, day->get().day);
  } else {
    table->complain("until", "'until' must be a date without quotes, such as 2026-12-31");
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
  each_name(outer, "accelerations", [&](const TableReader& table, std::string_view name) {
    const std::size_t dot = name.rfind('.');
    if (dot == std::string_view::npos) {
      table.complain(name, fmt::format("'{}' must be \"joint.coordinate\", such as \"hinge.turn_z\"", name));
    } else if (const auto value = table.number(name)) {
      asked.push_back({std::string(name.substr(0, dot)), std::string(name.substr(dot + 1)), *value, table.where(name)});
    }
  });
  return asked;
}

namespace {

std::optional<StartDraws> read_start(const TableReader& outer) {
  const auto table = inner_table(outer, "start", {"seed", "count", "turn", "slide", "turn_speed", "slide_speed"});
  if (!table || !table->require({"seed", "count"})) return std::nullopt;
  StartDraws draws;
  draws.first.seed = static_cast<std::uint64_t>(table->count("seed", 0).value_or(0));
  draws.count = table->count("count", 1, 100000).value_or(1);
  bool says_something = false;
  const auto read_size = [&](const char* key, double& size) {
    size = table->number_not_negative(key).value_or(0.0);
    says_something = says_something || table->has(key);
  };
  read_size("turn", draws.first.turn);
  read_size("slide", draws.first.slide);
  read_size("turn_speed", draws.first.turn_speed);
  read_size("slide_speed", draws.first.slide_speed);
  if (!says_something) table->complain("says nothing: give 'turn', 'slide', 'turn_speed' or 'slide_speed'");
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
  const auto table = inner_table(outer, "sweep", {"parameters", "cut", "integrators", "rtol", "start"});
  if (!table) return sweep;
  each_name(*table, "parameters", [&](const TableReader& values, std::string_view name) {
    if (auto swept = read_swept(values, name)) sweep.parameters.emplace_back(name, std::move(*swept));
  });
  each_name(*table, "cut", [&](const TableReader& cuts, std::string_view name) {
    if (auto joints = read_texts(cuts, name)) sweep.cuts.emplace_back(name, std::move(*joints));
  });
  read_integrators(*table, sweep);
  sweep.rtol = read_swept(*table, "rtol").value_or(std::vector<double>());
  for (const double rtol : sweep.rtol) {
    if (rtol >= kTightestTolerance && rtol <= kLoosestTolerance) continue;
    table->complain("rtol", fmt::format("tolerances must lie between {:g} and {:g}, found {:g}", kTightestTolerance,
                                        kLoosestTolerance, rtol));
  }
  sweep.start = read_start(*table);
  return sweep;
}

}  // namespace concord::compare::nightly
