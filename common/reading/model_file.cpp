#include "common/reading/model_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "common/reading/body_reader.h"
#include "common/reading/coupling_reader.h"
#include "common/reading/force_element_reader.h"
#include "common/reading/joint_reader.h"
#include "common/reading/magnitude.h"
#include "common/reading/model_checks.h"
#include "common/reading/model_parts.h"
#include "common/reading/road_reader.h"
#include "common/reading/spelling.h"
#include "common/reading/text_file.h"

namespace concord {

namespace {

constexpr std::string_view kGroundName = "ground";

/// Names that are taken, with the place of their owner.
class NameBook {
 public:
  /// Complains if the name, to which the file's prefix is added, is taken; true if not.
  bool enter(std::string_view kind, const std::string& name, const SourceLocation& where, FileReading& reading) {
    if (name.empty()) return true;
    const auto [entry, is_new] = owners_.emplace(reading.prefix + name, where);
    if (is_new) return true;
    const SourceLocation& other = entry->second;
    const bool is_same = other.file == where.file && other.line == where.line && other.column == where.column;
    const std::string place =
        other.file == where.file ? fmt::format("line {}", other.line) : fmt::format("{}:{}", other.file, other.line);
    reading.complain(where,
                     fmt::format("{} '{}': {}", kind, entry->first,
                                 is_same ? "the file is included twice: give each [[include]] a prefix of its own"
                                         : place + " has the same name: choose another"));
    return false;
  }

 private:
  std::map<std::string, SourceLocation> owners_;
};

/// What has been read of a model's files so far.
struct Reading {
  std::vector<BodyReading> bodies = std::vector<BodyReading>(1);
  std::vector<RoadReading> roads;
  std::vector<Joint> joints;
  /// Names of all joints, of those that could not be read too.
  std::vector<std::string> joint_names;
  /// Every body and every joint is what its name says: a gap in their graph is no consequence of another fault.
  bool graph_is_complete = true;
};

void read_bodies(ModelPart& part, NameBook& names, Reading& result) {
  for (const toml::table* table : part.document->tables("body")) {
    result.bodies.push_back(read_body(*table, part.reading));
    const Body& body = result.bodies.back().body;
    const std::string name = body.name.substr(std::min(part.reading.prefix.size(), body.name.size()));
    if (name == kGroundName || body.name == kGroundName) {
      part.reading.complain(body.where, "body 'ground': ground is there already and stands still: choose another name");
    } else if (!names.enter("body", name, body.where, part.reading)) {
      result.graph_is_complete = false;
    }
  }
}

void read_all_bodies(ModelParts& parts, Reading& result) {
  result.bodies.front().body.name = kGroundName;
  NameBook names;
  for (ModelPart& part : parts) read_bodies(part, names, result);
  const bool has_body =
      std::any_of(parts.begin(), parts.end(), [](const ModelPart& part) { return part.document->has("body"); });
  if (!has_body) parts.front().document->complain("there is no body: write at least one [[body]]");
}

void read_joints(ModelPart& part, Reading& result) {
  for (const NamedPlace& one : names_in(part, "joint")) {
    result.joint_names.push_back(part.reading.prefix + one.name);
  }
  for (const toml::table* table : part.document->tables("joint")) {
    if (auto joint = read_joint(*table, result.bodies, part.reading)) {
      result.joints.push_back(std::move(*joint));
    } else {
      result.graph_is_complete = false;
    }
  }
}

/// Appends what one part of the model has of a kind.
template <class Item>
void append(std::vector<Item> more, std::vector<Item>& all) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

/// Complains of names that joints, couplings and force elements share: they stand in one table of results.
void check_names(ModelParts& parts) {
  NameBook names;
  NameBook roads;
  KnownKeys kinds = force_element_keys();
  kinds.insert(kinds.begin(), {"joint", "coupling"});
  for (ModelPart& part : parts) {
    for (const std::string_view kind : kinds) {
      for (const auto& [name, where] : names_in(part, kind)) names.enter(kind, name, where, part.reading);
    }
    for (const auto& [name, where] : names_in(part, "road")) roads.enter("road", name, where, part.reading);
  }
}

/// The first file of the model that has the key; nothing if none has.
const TableReader* first_with(std::string_view key, const ModelParts& parts) {
  const auto found =
      std::find_if(parts.begin(), parts.end(), [&](const ModelPart& one) { return one.document->has(key); });
  return found == parts.end() ? nullptr : &*found->document;
}

RunSettings read_run(const TableReader& document) {
  RunSettings run;
  const toml::table* found = document.table("run");
  if (found == nullptr) return run;
  const TableReader table(*found, "run", {"until", "rtol", "samples", "start"}, document.reading());
  run.until = table.positive_number("until").value_or(run.until);
  run.rtol = table.positive_number("rtol");
  if (run.rtol && !(*run.rtol >= kTightestTolerance && *run.rtol <= kLoosestTolerance)) {
    table.complain("rtol", fmt::format("'rtol' must lie between {:g} and {:g}, found {:g}", kTightestTolerance,
                                       kLoosestTolerance, *run.rtol));
  }
  constexpr int kMostSamples = 1000000;
  run.samples = table.count("samples", 1, kMostSamples);
  if (const auto start = table.text("start")) {
    run.from_equilibrium = *start == "equilibrium";
    if (!run.from_equilibrium && *start != "given") {
      table.complain("start", fmt::format("'start' of a run is \"given\" or \"equilibrium\", found \"{}\"", *start));
    }
  }
  return run;
}

/// A force element of the file, or of one that includes it.
std::string element_in_model(const FileReading& reading, const std::string& name) {
  for (const std::string_view table : force_element_keys()) {
    if (std::string full = reading.name_in_model(table, name); full != name) return full;
  }
  return name;
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
    const TableReader table(*found, "need",
                            {"joint", "element", "body", "component", "same_state", "same_run", "refined", "because"},
                            document.reading());
    NeedOverride need;
    need.where = table.where();
    const std::string joint = table.text("joint").value_or("");
    if (!joint.empty()) check_joint_name(table, joint, joints);
    need.joint = document.reading().name_in_model("joint", joint);
    need.element = element_in_model(document.reading(), table.text("element").value_or(""));
    need.body = document.reading().name_in_model("body", table.text("body").value_or(""));
    need.component = table.text("component").value_or("");
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

/// Complaints about what stands in a file of the model are reported by that file's reading.
void tell(Diagnostic complaint, ModelParts& parts) {
  const auto part = std::find_if(parts.begin(), parts.end(),
                                 [&](const ModelPart& one) { return one.reading.file == complaint.where.file; });
  part->reading.complain(complaint.where, std::move(complaint.message));
}

/// Complains of bodies that nothing connects to ground, where the first of them stands.
void check_graph(const Model& model, ModelParts& parts) {
  std::vector<std::string> names;
  for (const int i : bodies_without_ground(model)) names.push_back(model.bodies[i].name);
  if (names.empty()) return;
  const SourceLocation where = model.bodies[bodies_without_ground(model).front()].where;
  tell({where,
        fmt::format("no chain of joints connects to ground: {}: add a joint, of type \"free\" if nothing holds it",
                    join_names(names))},
       parts);
}

KnownKeys keys_of_models() {
  KnownKeys known{"name", "gravity", "body", "joint", "coupling", "road", "run", "need"};
  known.insert(known.end(), force_element_keys().begin(), force_element_keys().end());
  return known;
}

/// Values from outside as definitions. Throws InputError with those that no number of a model can be.
std::vector<ParameterDefinition> definitions_of(const std::map<std::string, double>& parameters,
                                                const std::string& file) {
  std::vector<ParameterDefinition> definitions;
  std::vector<Diagnostic> complaints;
  for (const auto& [name, value] : parameters) {
    definitions.push_back({name, value, {file, 0, 0}});
    if (has_usable_size(value)) continue;
    complaints.push_back({{file, 0, 0}, fmt::format("parameter '{}' {}", name, complaint_about_size(value))});
  }
  if (!complaints.empty()) throw InputError(std::move(complaints));
  return definitions;
}

/// Complains of values from outside for parameters that the model file does not define.
void check_parameters(const std::map<std::string, double>& parameters, ModelPart& part) {
  std::vector<std::string> known;
  if (const toml::table* found = part.document->table("parameters")) {
    for (const auto& [key, value] : *found) known.emplace_back(key.str());
  }
  for (const auto& [name, value] : parameters) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    part.reading.complain({part.reading.file, 0, 0},
                          fmt::format("there is no parameter '{}': {}", name, suggestion(name, known, "parameters")));
  }
}

/// What was put right, with its place; what is said of a file that is included twice is told once.
std::vector<std::string> notes_of(const ModelParts& parts) {
  std::vector<std::string> notes;
  for (const ModelPart& part : parts) {
    for (const auto& [where, message] : part.reading.notes) {
      std::string note = fmt::format("{}:{}:{}: {}", where.file, where.line, where.column, message);
      if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(std::move(note));
    }
  }
  return notes;
}

bool has_complaints(const ModelParts& parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [](const ModelPart& part) { return !part.reading.complaints.empty(); });
}

/// A model that has no name is called as its file, without the ending.
std::string name_from(const std::filesystem::path& file, const TableReader& document) {
  std::string name = file.stem().string();
  const auto is_control = [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; };
  if (std::any_of(name.begin(), name.end(), is_control))
    document.complain(fmt::format("'name' is missing, and the file's, {:?}, is no name: it must be one line", name));
  return name;
}

/// What the parts say. Throws InputError with all that is wrong in them.
Model model_of(ModelParts& parts, const std::filesystem::path& file) {
  Model model;
  model.file = file.generic_string();
  const TableReader& document = *parts.front().document;
  model.name = document.has("name") ? document.name() : name_from(file, document);
  if (const TableReader* one = first_with("gravity", parts))
    model.gravity = one->vector3("gravity").value_or(Vec3::Zero());
  if (const TableReader* one = first_with("run", parts)) model.run = read_run(*one);
  Reading found;
  read_all_bodies(parts, found);
  for (const ModelPart& part : parts) append(read_roads(*part.document), found.roads);
  // Without any body every joint would only repeat that.
  const bool has_bodies = found.bodies.size() > 1;
  if (has_bodies) {
    for (ModelPart& part : parts) read_joints(part, found);
    for (const ModelPart& part : parts) {
      append(read_couplings(*part.document, found.joints, found.joint_names), model.couplings);
      append(read_force_elements(*part.document, found.bodies, found.roads), model.elements);
    }
  }
  check_names(parts);
  for (const ModelPart& part : parts) append(read_needs(*part.document, found.joint_names), model.needs);
  model.joints = std::move(found.joints);
  for (BodyReading& one : found.bodies) model.bodies.push_back(std::move(one.body));
  if (has_bodies && found.graph_is_complete) check_graph(model, parts);
  // Of numbers that could be read.
  if (!has_complaints(parts)) {
    for (Diagnostic& complaint : complaints_about_products(model)) tell(std::move(complaint), parts);
  }
  throw_if_any(parts);
  model.notes = notes_of(parts);
  return model;
}

}  // namespace

std::vector<std::filesystem::path> files_of_model(const std::filesystem::path& file) {
  std::vector<std::filesystem::path> files{file};
  try {
    const ModelParts parts = read_model_parts(read_text_file(file), file, keys_of_models());
    for (const ModelPart& part : parts) {
      const std::filesystem::path of_part = part.reading.file;
      files.push_back(of_part);
      const toml::array* bodies = part.root["body"].as_array();
      if (bodies == nullptr) continue;
      for (const toml::node& body : *bodies) {
        const toml::table* table = body.as_table();
        if (table == nullptr) continue;
        if (const auto modes = (*table)["modes_file"].value<std::string>()) {
          files.push_back(of_part.parent_path() / *modes);
        }
      }
    }
  } catch (const InputError&) {  // what can be read of it was found; reading the model tells the fault
  }
  return files;
}

Model read_model(const std::filesystem::path& file) { return parse_model(read_text_file(file), file); }

Model read_model(const std::filesystem::path& file, const std::map<std::string, double>& parameters) {
  ModelParts parts =
      read_model_parts(read_text_file(file), file, keys_of_models(), definitions_of(parameters, file.generic_string()));
  check_parameters(parameters, parts.front());
  return model_of(parts, file);
}

Model parse_model(std::string_view text, const std::filesystem::path& file) {
  ModelParts parts = read_model_parts(text, file, keys_of_models());
  return model_of(parts, file);
}

}  // namespace concord
