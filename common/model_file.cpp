#include "common/model_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "common/body_reader.h"
#include "common/coupling_reader.h"
#include "common/force_element_reader.h"
#include "common/joint_reader.h"
#include "common/model_checks.h"
#include "common/spelling.h"
#include "common/toml_reader.h"

namespace concord {

namespace {

constexpr int kFormat = 1;
constexpr std::string_view kGroundName = "ground";

void read_parameters(const TableReader& document, FileReading& reading) {
  const toml::table* found = document.table("parameters");
  if (found == nullptr) return;
  std::vector<ParameterDefinition> definitions;
  for (const auto& [key, value] : *found) {
    const SourceLocation where = reading.at(value.source());
    if (value.is_number()) {
      definitions.push_back({std::string(key.str()), *value.value<double>(), where});
    } else if (value.is_string()) {
      definitions.push_back({std::string(key.str()), **value.as_string(), where});
    } else {
      definitions.push_back({std::string(key.str()), std::monostate{}, where});
      reading.complain(where, fmt::format("parameter '{}': must be a number or an expression, found {}", key.str(),
                                          type_name(value)));
    }
  }
  std::sort(definitions.begin(), definitions.end(), [](const auto& a, const auto& b) {
    return std::pair(a.where.line, a.where.column) < std::pair(b.where.line, b.where.column);
  });
  reading.parameters = Parameters(definitions, reading.complaints);
}

/// Names that are taken, with the place of their owner.
class NameBook {
 public:
  explicit NameBook(FileReading& reading) : reading_(&reading) {}

  /// Complains if the name is taken.
  void enter(std::string_view kind, const std::string& name, const SourceLocation& where) {
    if (name.empty()) return;
    const auto [entry, is_new] = owners_.emplace(name, where);
    if (is_new) return;
    reading_->complain(
        where, fmt::format("{} '{}': line {} has the same name: choose another", kind, name, entry->second.line));
  }

 private:
  FileReading* reading_;
  std::map<std::string, SourceLocation> owners_;
};

std::vector<BodyReading> read_bodies(const TableReader& document, FileReading& reading) {
  std::vector<BodyReading> bodies(1);
  bodies.front().body.name = kGroundName;
  NameBook names(reading);
  for (const toml::table* table : document.tables("body")) {
    bodies.push_back(read_body(*table, reading));
    const Body& body = bodies.back().body;
    if (body.name == kGroundName) {
      reading.complain(body.where, "body 'ground': ground is there already and stands still: choose another name");
    } else {
      names.enter("body", body.name, body.where);
    }
  }
  if (!document.has("body")) document.complain("there is no body: write at least one [[body]]");
  return bodies;
}

struct JointsReading {
  std::vector<Joint> joints;
  /// Names of all joints, of those that could not be read too.
  std::vector<std::string> names;
  bool is_complete = true;
};

JointsReading read_joints(const TableReader& document, const std::vector<BodyReading>& bodies, FileReading& reading) {
  JointsReading result;
  for (const toml::table* table : document.tables("joint")) {
    const toml::node* name = table->get("name");
    if (name != nullptr && name->is_string()) result.names.push_back(**name->as_string());
    if (auto joint = read_joint(*table, bodies, reading)) {
      result.joints.push_back(std::move(*joint));
    } else {
      result.is_complete = false;
    }
  }
  return result;
}

/// Complains of names that joints, couplings and force elements share: they stand in one table of results.
void check_names(const TableReader& document, FileReading& reading) {
  NameBook names(reading);
  KnownKeys kinds = force_element_keys();
  kinds.insert(kinds.begin(), {"joint", "coupling"});
  for (const std::string_view kind : kinds) {
    const toml::array* owners = document.has(kind) ? document.node(kind)->as_array() : nullptr;
    if (owners == nullptr) continue;
    for (const toml::node& owner : *owners) {
      const toml::node* name = owner.is_table() ? owner.as_table()->get("name") : nullptr;
      if (name != nullptr && name->is_string()) {
        names.enter(kind, **name->as_string(), reading.at(name->source()));
      }
    }
  }
}

RunSettings read_run(const TableReader& document) {
  RunSettings run;
  const toml::table* found = document.table("run");
  if (found == nullptr) return run;
  const TableReader table(*found, "run", {"until", "rtol", "samples", "start"}, document.reading());
  run.until = table.positive_number("until").value_or(run.until);
  run.rtol = table.positive_number("rtol");
  run.samples = table.count("samples", 1);
  if (const auto start = table.text("start")) {
    run.from_equilibrium = *start == "equilibrium";
    if (!run.from_equilibrium && *start != "given") {
      table.complain("start", fmt::format("'start' of a run is \"given\" or \"equilibrium\", found \"{}\"", *start));
    }
  }
  return run;
}

void check_joint_name(const TableReader& need, const std::string& name, const std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), name) != names.end()) return;
  need.complain("joint", fmt::format("unknown joint '{}': {}", name, suggestion(name, names, "joints")));
}

void check_component(const TableReader& need, const std::string& name) {
  static const std::vector<std::string> kComponents{"F_x", "F_y", "F_z", "T_x", "T_y", "T_z"};
  if (std::find(kComponents.begin(), kComponents.end(), name) != kComponents.end()) return;
  need.complain("component",
                fmt::format("unknown component '{}': known components: {}", name, join_names(kComponents)));
}

std::optional<double> read_digits(const TableReader& need, std::string_view key) {
  constexpr double kMost = 16.0;
  const auto digits = need.number_not_negative(key);
  if (!digits || *digits <= kMost) return digits;
  need.complain(key, fmt::format("'{}' must be at most {} digits, found {}", key, kMost, *digits));
  return std::nullopt;
}

std::vector<NeedOverride> read_needs(const TableReader& document, const std::vector<std::string>& joints) {
  std::vector<NeedOverride> needs;
  for (const toml::table* found : document.tables("need")) {
    const TableReader table(*found, "need", {"joint", "component", "same_state", "same_run", "refined", "because"},
                            document.reading());
    NeedOverride need;
    need.where = table.where();
    need.joint = table.text("joint").value_or("");
    need.component = table.text("component").value_or("");
    if (!need.joint.empty()) check_joint_name(table, need.joint, joints);
    if (!need.component.empty()) check_component(table, need.component);
    need.same_state = read_digits(table, "same_state");
    need.same_run = read_digits(table, "same_run");
    need.refined = read_digits(table, "refined");
    need.because = table.text("because").value_or("");
    if (!table.has("same_state") && !table.has("same_run") && !table.has("refined")) {
      table.complain("says nothing: give 'same_state', 'same_run' or 'refined'");
    }
    needs.push_back(std::move(need));
  }
  return needs;
}

/// Complains of bodies that nothing connects to ground. Only for a graph whose joints could all be read: else its gaps
/// are consequences.
void check_graph(const Model& model, FileReading& reading) {
  std::vector<std::string> names;
  for (const int i : bodies_without_ground(model)) names.push_back(model.bodies[i].name);
  if (names.empty()) return;
  const SourceLocation where = model.bodies[bodies_without_ground(model).front()].where;
  reading.complain(where, fmt::format("no chain of joints connects to ground: {}: add a joint, of type \"free\" if "
                                      "nothing holds it",
                                      join_names(names)));
}

}  // namespace

Model read_model(const std::filesystem::path& file) { return parse_model(read_text_file(file), file); }

Model parse_model(std::string_view text, const std::filesystem::path& file) {
  FileReading reading;
  reading.file = file.generic_string();
  const toml::table root = parse_toml(text, reading.file);
  KnownKeys known{"format", "name", "gravity", "parameters", "body", "joint", "coupling", "run", "need"};
  known.insert(known.end(), force_element_keys().begin(), force_element_keys().end());
  const TableReader document(root, "", known, reading);
  check_format(document, kFormat);
  read_parameters(document, reading);

  Model model;
  model.file = reading.file;
  model.name = document.text("name").value_or(file.stem().string());
  model.gravity = document.vector3("gravity").value_or(Vec3::Zero());
  model.run = read_run(document);
  std::vector<BodyReading> bodies = read_bodies(document, reading);
  // Without any body every joint would only repeat that.
  const bool has_bodies = bodies.size() > 1;
  JointsReading joints = has_bodies ? read_joints(document, bodies, reading) : JointsReading{};
  model.joints = std::move(joints.joints);
  if (has_bodies) model.couplings = read_couplings(document, model.joints, joints.names);
  if (has_bodies) model.elements = read_force_elements(document, bodies);
  check_names(document, reading);
  model.needs = read_needs(document, joints.names);
  for (BodyReading& one : bodies) model.bodies.push_back(std::move(one.body));
  if (has_bodies && joints.is_complete) check_graph(model, reading);
  reading.throw_if_any();
  return model;
}

}  // namespace concord
