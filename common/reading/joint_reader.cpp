#include "common/reading/joint_reader.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "common/joints/catalogue.h"
#include "common/reading/attachment_reader.h"
#include "common/reading/driver_reader.h"
#include "common/reading/force_law_reader.h"
#include "common/reading/orientation_reader.h"
#include "common/reading/spelling.h"
#include "common/reading/toml_document.h"

namespace concord {

namespace {

/// q of a word: a number, or for a ball the Euler parameters of an orientation.
std::optional<VecX> read_q(const TableReader& table, std::string_view key, const joints::Permit& word) {
  if (!is_orientation(word)) {
    const auto value = table.number(key);
    if (!value) return std::nullopt;
    return VecX(VecX::Constant(1, *value));
  }
  const toml::table* found = table.node(key)->as_table();
  if (found == nullptr) {
    table.complain(key, fmt::format("'{}' of a ball must be an orientation, such as {{ axis = [0, 0, 1], angle = \"30 "
                                    "deg\" }}, found {}",
                                    key, type_name(*table.node(key))));
    return std::nullopt;
  }
  const TableReader orientation(*found, table.title(), with_orientation({}), table.reading());
  const auto R = read_orientation(orientation);
  if (!R) return std::nullopt;
  const Eigen::Quaterniond rotation(*R);
  return VecX(Vec4(rotation.w(), rotation.x(), rotation.y(), rotation.z()));
}

std::optional<VecX> read_u(const TableReader& table, std::string_view key, const joints::Permit& word) {
  if (is_orientation(word)) return table.vector(key, n_u(word));
  const auto value = table.number(key);
  if (!value) return std::nullopt;
  return VecX(VecX::Constant(1, *value));
}

WordStart unsaid(const joints::Permit& word) {
  WordStart start;
  start.q = joints::home_of(word);
  start.u = VecX::Zero(n_u(word));
  if (is_orientation(word)) return start;
  start.slack_q = VecX::Constant(start.q.size(), kWrittenExactly);
  start.slack_u = VecX::Constant(start.u.size(), kWrittenExactly);
  return start;
}

/// Whether `kept` or `guessed` is said; complains of both.
StartRole read_role(const TableReader& table, std::string_view kept, std::string_view guessed) {
  if (!table.has(kept) && !table.has(guessed)) return StartRole::unsaid;
  if (!table.require_one_of({kept, guessed})) return StartRole::unsaid;
  return table.has(kept) ? StartRole::keep : StartRole::guess;
}

/// What is said of the start of one named coordinate: all numbers of a ball, one number of any other.
WordStart read_coordinate_start(const TableReader& table, const joints::Permit& word) {
  WordStart start;
  start.role_q = read_role(table, "keep", "guess");
  start.role_u = read_role(table, "keep_speed", "guess_speed");
  const bool is_one = !is_orientation(word);
  if (start.role_q != StartRole::unsaid) {
    const char* const key = start.role_q == StartRole::keep ? "keep" : "guess";
    start.q = read_q(table, key, word).value_or(VecX());
    if (is_one && start.q.size() == 1) start.slack_q = VecX::Constant(1, table.slack_of(key));
  }
  if (start.role_u != StartRole::unsaid) {
    const char* const key = start.role_u == StartRole::keep ? "keep_speed" : "guess_speed";
    start.u = read_u(table, key, word).value_or(VecX());
    if (is_one && start.u.size() == 1) start.slack_u = VecX::Constant(1, table.slack_of(key));
  }
  return start;
}

/// Enters what is said of a coordinate into its word. The coordinates of one word share a role.
void enter(const WordStart& said, int component, WordStart& word) {
  const auto put = [&](const VecX& from, VecX& to) {
    if (from.size() > 0) to.segment(component, from.size()) = from;
  };
  put(said.q, word.q);
  put(said.u, word.u);
  put(said.slack_q, word.slack_q);
  put(said.slack_u, word.slack_u);
  word.role_q = std::max(word.role_q, said.role_q);
  word.role_u = std::max(word.role_u, said.role_u);
}

/// Reads the table `key` of a joint, whose keys are coordinates of the joint: calls `read` with the table and each
/// coordinate that is there.
template <class Read>
void for_each_coordinate(const TableReader& joint_table, std::string_view key, const joints::JointType& type,
                         const Read& read) {
  const toml::table* found = joint_table.table(key);
  if (found == nullptr) return;
  const std::vector<NamedCoordinate> coordinates = named_coordinates(type);
  KnownKeys known;
  for (const NamedCoordinate& coordinate : coordinates) known.push_back(coordinate.name);
  const TableReader table(*found, fmt::format("{} ({}), {}", joint_table.title(), type.name, key), known,
                          joint_table.reading());
  for (const NamedCoordinate& coordinate : coordinates) {
    if (table.has(coordinate.name)) read(table, coordinate);
  }
}

void read_drivers(const TableReader& joint_table, Joint& joint) {
  for_each_coordinate(
      joint_table, "drive", *joint.type, [&](const TableReader& table, const NamedCoordinate& coordinate) {
        if (coordinate.kind == joints::CoordinateKind::orientation) {
          table.complain(coordinate.name, "a ball cannot be driven: only a turn or a slide follows a law of time");
          return;
        }
        const toml::table* law_table = table.table(coordinate.name);
        if (law_table == nullptr) return;
        const std::string title = fmt::format("{}, {}", table.title(), coordinate.name);
        if (auto law = read_time_function(*law_table, title, table.reading())) {
          joint.drivers.push_back({coordinate.word, std::move(*law), coordinate.component});
        }
      });
}

void read_springs(const TableReader& joint_table, Joint& joint) {
  for_each_coordinate(joint_table, "spring", *joint.type,
                      [&](const TableReader& table, const NamedCoordinate& coordinate) {
                        if (coordinate.kind == joints::CoordinateKind::orientation) {
                          table.complain(coordinate.name,
                                         "a ball has no spring: only a turn or a slide has; a force element between "
                                         "the bodies can resist all rotations");
                          return;
                        }
                        const toml::table* law = table.table(coordinate.name);
                        if (law == nullptr) return;
                        const TableReader law_table(*law, fmt::format("{}, {}", table.title(), coordinate.name),
                                                    with_force_law({}), table.reading());
                        joint.springs.push_back({coordinate.word, read_force_law(law_table), coordinate.component});
                      });
}

/// Complains unless the coordinates of a motion by functions that no law drives are kept all, guessed all or left out
/// all: their word starts as one.
void check_common_role(const TableReader& table, const std::vector<WordStart>& said, const Joint& joint) {
  const std::vector<NamedCoordinate> coordinates = named_coordinates(*joint.type);
  for (std::size_t k = 1; k < coordinates.size(); ++k) {
    const NamedCoordinate& one = coordinates[k];
    const NamedCoordinate& other = coordinates[k - 1];
    if (one.word != other.word || driver_of(joint, one.word, one.component) != nullptr ||
        driver_of(joint, other.word, other.component) != nullptr) {
      continue;
    }
    if (said[k].role_q == said[k - 1].role_q && said[k].role_u == said[k - 1].role_u) continue;
    table.complain("start", fmt::format("'{}' and '{}' start alike: keep both, guess both or leave both out",
                                        other.name, one.name));
  }
}

void read_start(const TableReader& joint_table, Joint& joint) {
  for (const joints::Permit& word : joint.type->permits) joint.start.push_back(unsaid(word));
  std::vector<WordStart> said(named_coordinates(*joint.type).size());
  for_each_coordinate(
      joint_table, "start", *joint.type, [&](const TableReader& table, const NamedCoordinate& coordinate) {
        const toml::table* found = table.table(coordinate.name);
        if (found == nullptr) return;
        const TableReader one(*found, fmt::format("{}, {}", table.title(), coordinate.name),
                              {"keep", "guess", "keep_speed", "guess_speed"}, table.reading());
        WordStart& start = said[coordinate.place];
        start = read_coordinate_start(one, joint.type->permits[coordinate.word]);
        enter(start, coordinate.component, joint.start[coordinate.word]);
        if (driver_of(joint, coordinate.word, coordinate.component) == nullptr) return;
        table.complain(coordinate.name, fmt::format("'{}' is driven, so its start follows from the law: leave this out",
                                                    coordinate.name));
      });
  check_common_role(joint_table, said, joint);
}

const joints::JointType* read_type(const TableReader& table) {
  const auto name = table.text("type");
  if (!name) return nullptr;
  if (const joints::JointType* type = joints::find(*name)) return type;
  std::vector<std::string> names;
  for (const joints::JointType* type : joints::catalogue()) names.push_back(type->name);
  table.complain("type", fmt::format("unknown joint type '{}': {}", *name, help_with_word(*name, names, "types")));
  return nullptr;
}

/// Keys of a joint: those of all joints, and the parameters of its type. While the type is not known, those of all.
KnownKeys keys_of(const joints::JointType* type) {
  KnownKeys keys = with_ends({"name", "type", "cut", "start", "drive", "spring"});
  for (const joints::JointType* one : joints::catalogue()) {
    if (type != nullptr && type != one) continue;
    for (const joints::Parameter& parameter : one->parameters) keys.push_back(parameter.name);
  }
  return keys;
}

/// Gives the joint the type that has its own parameters; keeps that of the catalogue after a complaint.
void read_parameters(const TableReader& table, Joint& joint) {
  std::vector<double> values;
  for (const joints::Parameter& parameter : joint.type->parameters) {
    if (!table.has(parameter.name)) {
      table.complain(
          fmt::format("missing key '{}' [{}]: a {} joint has one", parameter.name, parameter.unit, joint.type->name));
    } else if (const auto value = table.positive_number(parameter.name)) {
      values.push_back(*value);
    }
  }
  if (values.empty() || values.size() != joint.type->parameters.size()) return;
  joint.own_type = std::make_shared<const joints::JointType>(joint.type->with_parameters(values));
  joint.type = joint.own_type.get();
}

/// The type that a joint names, if it is in the catalogue.
const joints::JointType* named_type(const toml::table& joint) {
  const toml::node* type = joint.get("type");
  return type != nullptr && type->is_string() ? joints::find(**type->as_string()) : nullptr;
}

}  // namespace

std::optional<Joint> read_joint(const toml::table& found, const std::vector<BodyReading>& bodies,
                                FileReading& reading) {
  const TableReader table(found, title_with_name(found, "joint"), keys_of(named_type(found)), reading);
  table.require({"type"});
  Joint joint;
  joint.where = table.where();
  joint.name = table.name();
  joint.type = read_type(table);
  joint.named_as_cut = table.flag("cut").value_or(false);
  const auto ends = read_ends(table, bodies);
  if (joint.type == nullptr) return std::nullopt;
  read_parameters(table, joint);
  read_drivers(table, joint);
  read_springs(table, joint);
  read_start(table, joint);
  if (!ends) return std::nullopt;
  joint.sides = *ends;
  return joint;
}

void check_joint_name(const TableReader& table, const std::string& name, const std::vector<std::string>& joints) {
  const FileReading& reading = table.reading();
  if (std::find(joints.begin(), joints.end(), reading.name_in_model("joint", name)) != joints.end()) return;
  std::vector<std::string> known;
  for (const std::string& one : joints) known.push_back(reading.name_in_file("joint", one));
  table.complain("joint", fmt::format("unknown joint '{}': {}", name, suggestion(name, known, "joints")));
}

}  // namespace concord
