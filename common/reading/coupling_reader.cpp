#include "common/reading/coupling_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/reading/spelling.h"
#include "common/reading/toml_document.h"

namespace concord {

namespace {

/// The joint of a name, -1 if there is none or if it could not be read; complains of a name that no joint has.
int find_joint(const TableReader& table, const std::string& name, const std::vector<Joint>& joints,
               const std::vector<std::string>& names) {
  const std::string wanted = table.reading().name_in_model("joint", name);
  const auto found =
      std::find_if(joints.begin(), joints.end(), [&](const Joint& joint) { return joint.name == wanted; });
  if (found != joints.end()) return static_cast<int>(found - joints.begin());
  check_joint_name(table, name, names);
  return -1;
}

/// Finds the coordinate of a name in the joint; complains if there is none, or if it is a ball.
bool find_coordinate(const TableReader& table, const std::string& name, const Joint& joint, CouplingTerm& term) {
  std::vector<std::string> names;
  for (const NamedCoordinate& coordinate : named_coordinates(*joint.type)) {
    if (coordinate.kind == joints::CoordinateKind::orientation) {
      if (coordinate.name != name) continue;
      table.complain("coordinate", "a ball cannot be coupled: only a turn or a slide can");
      return false;
    }
    names.push_back(coordinate.name);
    if (coordinate.name != name) continue;
    term.word = coordinate.word;
    term.component = coordinate.component;
    return true;
  }
  table.complain("coordinate", fmt::format("joint '{}' ({}) has no coordinate '{}': {}", joint.name, joint.type->name,
                                           name, suggestion(name, names, "coordinates")));
  return false;
}

std::optional<CouplingTerm> read_term(const toml::table& found, const std::string& title,
                                      const std::vector<Joint>& joints, const std::vector<std::string>& names,
                                      FileReading& reading) {
  const TableReader table(found, title, {"joint", "coordinate", "factor"}, reading);
  if (!table.require({"joint", "coordinate", "factor"})) return std::nullopt;
  const auto joint = table.text("joint");
  const auto coordinate = table.text("coordinate");
  const auto factor = table.number("factor");
  if (!joint || !coordinate || !factor) return std::nullopt;
  CouplingTerm term;
  term.factor = *factor;
  if (term.factor == 0.0) {
    table.complain("factor", "'factor' must not be zero: leave the term out");
    return std::nullopt;
  }
  term.joint = find_joint(table, *joint, joints, names);
  if (term.joint < 0 || !find_coordinate(table, *coordinate, joints[term.joint], term)) return std::nullopt;
  return term;
}

bool same_coordinate(const CouplingTerm& a, const CouplingTerm& b) {
  return a.joint == b.joint && a.word == b.word && a.component == b.component;
}

void read_terms(const TableReader& table, const std::vector<Joint>& joints, const std::vector<std::string>& names,
                Coupling& coupling) {
  const std::vector<const toml::table*> found = table.tables("terms");
  if (found.size() < 2) {
    table.complain("terms",
                   fmt::format("a coupling relates at least two coordinates, found {}: write terms = [{{ joint "
                               "= \"A\", coordinate = \"turn_z\", factor = 1 }}, ...]",
                               found.size()));
    return;
  }
  int number = 0;
  for (const toml::table* one : found) {
    ++number;
    const auto term =
        read_term(*one, fmt::format("{}, term {}", table.title(), number), joints, names, table.reading());
    if (!term) continue;
    const bool is_there = std::any_of(coupling.terms.begin(), coupling.terms.end(),
                                      [&](const CouplingTerm& other) { return same_coordinate(*term, other); });
    if (is_there) {
      table.reading().complain(table.reading().at(one->source()),
                               fmt::format("{}, term {}: this coordinate stands in the coupling already: add the "
                                           "factors",
                                           table.title(), number));
      continue;
    }
    coupling.terms.push_back(*term);
  }
}

}  // namespace

std::vector<Coupling> read_couplings(const TableReader& document, const std::vector<Joint>& joints,
                                     const std::vector<std::string>& names) {
  std::vector<Coupling> couplings;
  for (const toml::table* found : document.tables("coupling")) {
    const TableReader table(*found, title_with_name(*found, "coupling"), {"name", "terms", "offset"},
                            document.reading());
    Coupling& coupling = couplings.emplace_back();
    coupling.name = table.name();
    coupling.where = table.where();
    coupling.offset = table.number("offset").value_or(0.0);
    if (table.require({"terms"})) read_terms(table, joints, names, coupling);
  }
  return couplings;
}

}  // namespace concord
