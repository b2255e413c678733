#include "tests/second_reading/joints.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "common/joints/facts.h"
#include "tests/second_reading/laws.h"
#include "tests/second_reading/places.h"
#include "tests/second_reading/stated_file.h"

namespace concord::second_reading {

namespace {

std::string name_of(StartRole role) {
  return role == StartRole::keep ? "keep" : role == StartRole::guess ? "guess" : "unsaid";
}

/// The first of two keys that the table has, or nothing.
std::string role_in(const std::optional<StatedTable>& start, const std::string& keep, const std::string& guess) {
  if (start && start->has(keep)) return keep;
  return start && start->has(guess) ? guess : "";
}

/// Euler parameters of a frame, of the sign that is nearest to others.
VecX euler_parameters_of(const Mat3& R, const VecX& nearest) {
  const Eigen::Quaterniond turn(R);
  VecX p(4);
  p << turn.w(), turn.x(), turn.y(), turn.z();
  return nearest.size() == 4 && p.dot(nearest) < 0.0 ? VecX(-p) : p;
}

/// The numbers of one coordinate among those of its word.
VecX part_of(const VecX& numbers, const JointCoordinate& coordinate) {
  if (coordinate.kind == joints::CoordinateKind::orientation || coordinate.component >= numbers.size()) return numbers;
  return numbers.segment<1>(coordinate.component);
}

/// What is stated of a place: a number, or the Euler parameters of a frame. `key` is empty where nothing is.
VecX stated_place(const JointCoordinate& coordinate, const std::optional<StatedTable>& start, const std::string& key,
                  const VecX& read, double& doubt) {
  if (coordinate.kind != joints::CoordinateKind::orientation) {
    return VecX::Constant(1, key.empty() ? 0.0 : start->number(key).value());
  }
  StatedFrame frame;
  if (!key.empty()) frame = frame_of(start->table(key).value()).value_or(StatedFrame{});
  doubt = frame.doubt;
  return euler_parameters_of(frame.R, read);
}

VecX stated_speed(const JointCoordinate& coordinate, const std::optional<StatedTable>& start, const std::string& key) {
  const bool is_ball = coordinate.kind == joints::CoordinateKind::orientation;
  if (key.empty()) return VecX::Zero(is_ball ? 3 : 1);
  return is_ball ? VecX(start->vector(key).value()) : VecX::Constant(1, start->number(key).value());
}

/// Without a key nothing is said of a coordinate, and its number is zero.
void hold_start_of_coordinate(const JointCoordinate& coordinate, const WordStart& read, const StatedTable& table,
                              const std::optional<StatedTable>& start) {
  Ledger& ledger = table.ledger();
  const auto entry = [&](const std::string& key) {
    return start && !key.empty() ? start->entry(key) : table.entry("start." + coordinate.name);
  };
  const bool is_ball = coordinate.kind == joints::CoordinateKind::orientation;
  const std::string place = role_in(start, "keep", "guess");
  ledger.word(entry(place), name_of(read.role_q), place.empty() ? "unsaid" : place);
  const VecX q = part_of(read.q, coordinate);
  double doubt = 0.0;
  const VecX stated = stated_place(coordinate, start, place, q, doubt);
  ledger.numbers(entry(place), q, stated, kRoundOff + doubt, is_ball ? 1.0 : 0.0);
  const std::string speed = role_in(start, "keep_speed", "guess_speed");
  const std::string role = speed.empty() ? "unsaid" : speed.substr(0, speed.find('_'));
  ledger.word(entry(speed), name_of(read.role_u), role);
  ledger.numbers(entry(speed), part_of(read.u, coordinate), stated_speed(coordinate, start, speed));
}

/// Drivers and springs: one for each coordinate that the table names, and no other.
template <class Acts, class Hold>
void hold_on_coordinates(const Joint& joint, const StatedTable& table, const std::string& key, const Acts& acts,
                         const Hold& hold) {
  const auto stated = table.table(key);
  for (const JointCoordinate& coordinate : coordinates_of(*joint.type)) {
    const auto act = std::find_if(acts.begin(), acts.end(), [&](const auto& one) {
      return one.word == coordinate.word && one.component == coordinate.component;
    });
    const bool is_stated = stated && stated->has(coordinate.name);
    const Entry entry = is_stated ? stated->entry(coordinate.name) : table.entry(key + "." + coordinate.name);
    if (table.ledger().both_have(entry, act != acts.end(), is_stated)) hold(*stated, coordinate.name, act->law);
  }
  const std::size_t count = stated ? stated->keys().size() : 0;
  table.ledger().number(table.entry(key), static_cast<double>(acts.size()), static_cast<double>(count));
}

}  // namespace

std::vector<JointCoordinate> coordinates_of(const joints::JointType& type) {
  std::vector<JointCoordinate> all;
  for (std::size_t word = 0; word < type.permits.size(); ++word) {
    const joints::StatedCoordinates stated = joints::stated_coordinates(type.permits[word]);
    for (int k = 0; k < stated.size(); ++k) {
      const std::string name(stated[k].name);
      const auto before = std::count_if(all.begin(), all.end(), [&](const JointCoordinate& one) {
        return one.name == name || (one.name.starts_with(name) && one.name.size() == name.size() + 1 &&
                                    one.name.back() >= '2' && one.name.back() <= '9');
      });
      all.push_back({before > 0 ? name + std::to_string(before + 1) : name, static_cast<int>(word), k, stated[k].kind});
    }
  }
  return all;
}

void hold_start_of_joint(const Joint& joint, const StatedTable& table) {
  const auto all = table.table("start");
  table.ledger().number(table.entry("start"), static_cast<double>(joint.start.size()),
                        static_cast<double>(joint.type->permits.size()));
  if (joint.start.size() != joint.type->permits.size()) return;
  for (const JointCoordinate& coordinate : coordinates_of(*joint.type)) {
    const auto start = all ? all->table(coordinate.name) : std::nullopt;
    hold_start_of_coordinate(coordinate, joint.start[static_cast<std::size_t>(coordinate.word)], table, start);
  }
}

void hold_joint(const Model& model, const Joint& joint, const StatedTable& table) {
  hold_joint_type(joint, table);
  hold_sides(model, table, joint.sides);
  table.ledger().word(table.entry("cut"), joint.named_as_cut ? "true" : "false", table.flag("cut") ? "true" : "false");
  if (table.text("type") != joint.type->name) return;  // coordinates of another type are others
  hold_start_of_joint(joint, table);
  hold_on_coordinates(joint, table, "drive", joint.drivers,
                      [](const StatedTable& drive, const std::string& key, const TimeFunction& law) {
                        hold_law_of_time(law, drive, key);
                      });
  hold_on_coordinates(joint, table, "spring", joint.springs,
                      [](const StatedTable& spring, const std::string& key, const ForceLaw& law) {
                        hold_force_law(law, spring.table(key).value());
                      });
}

void hold_coupling(const Model& model, const Coupling& coupling, const StatedTable& table) {
  Ledger& ledger = table.ledger();
  table.hold_number("offset", coupling.offset, 0.0);
  const std::vector<StatedTable> terms = table.tables("terms");
  ledger.number(table.entry("terms"), static_cast<double>(coupling.terms.size()), static_cast<double>(terms.size()));
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const std::string joint = terms[k].reference(Names::joints, "joint");
    const std::string coordinate = terms[k].text("coordinate").value_or("");
    const double factor = terms[k].number("factor").value();
    if (k >= coupling.terms.size()) continue;
    const CouplingTerm& read = coupling.terms[k];
    const Joint& of_model = model.joints.at(static_cast<std::size_t>(read.joint));
    ledger.word(terms[k].entry("joint"), of_model.name, joint);
    std::string name;
    for (const JointCoordinate& one : coordinates_of(*of_model.type)) {
      if (one.word == read.word && one.component == read.component) name = one.name;
    }
    ledger.word(terms[k].entry("coordinate"), name, coordinate);
    ledger.number(terms[k].entry("factor"), read.factor, factor);
  }
}

}  // namespace concord::second_reading
