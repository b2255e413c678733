#include <cmath>
#include <stdexcept>

#include "common/joints/catalogue.h"
#include "common/joints/facts.h"
#include "compare/audit/referee.h"
#include "tests/second_reading/joints.h"
#include "tests/second_reading/stated_motions.h"

namespace concord::second_reading {

namespace {

using Numbers = std::vector<double>;

template <class List>
void append(Numbers& all, const List& list) {
  for (Eigen::Index k = 0; k < list.size(); ++k) all.push_back(list(k));
}

/// What functions of (d, R) and of q give in a pose that no symmetry marks out.
void append_function(Numbers& all, const joints::FunctionOfPlacement* function) {
  if (function == nullptr) return;
  joints::Placement at;
  at.d = Vec3(0.013, -0.021, 0.034);
  joints::FunctionOfPlacement::Rows rows;
  function->evaluate(at, Vec6::Zero(), rows);
  append(all, rows.value);
}

void append_function(Numbers& all, const joints::FunctionOfCoordinates* function) {
  if (function == nullptr) return;
  const std::array<double, 6> q{0.31, 0.23, 0.17, 0.13, 0.11, 0.07};
  const std::array<double, 6> u{};
  joints::FunctionOfCoordinates::Motion motion;
  function->evaluate(q.data(), u.data(), motion);
  append(all, motion.placement.d);
  append(all, motion.placement.R.reshaped());
}

/// Every number that the words of a type state.
Numbers numbers_of(const joints::JointType& type) {
  Numbers all;
  for (const joints::Forbid& word : type.forbids) {
    all.push_back(joints::stated_length(word));
    append_function(all, joints::function_of(word));
  }
  for (const joints::Permit& word : type.permits) {
    all.push_back(joints::stated_length(word));
    append_function(all, joints::function_of(word));
  }
  for (const joints::Read& word : type.reads) append_function(all, joints::function_of(word));
  for (const joints::ForbidSpeed& word : type.forbids_speeds) all.push_back(joints::stated_length(word));
  for (const joints::PermitSpeed& word : type.permits_speeds) all.push_back(joints::stated_length(word));
  return all;
}

/// Coordinates that no symmetry marks out.
VecX generic_coordinates(const joints::JointType& type) {
  VecX q(type.n_q());
  for (Eigen::Index k = 0; k < q.size(); ++k) q(k) = std::cos(1.0 + 2.0 * static_cast<double>(k));
  for (const JointCoordinate& one : coordinates_of(type)) {
    if (one.kind == joints::CoordinateKind::orientation) q.segment<4>(first_q(type, one.word)).normalize();
  }
  return q;
}

/// The motion that a type with these numbers permits, which both solvers take from the words of its page, is the one
/// that the format states.
void hold_motion(const joints::JointType& type, const Numbers& values, const StatedTable& table) {
  const VecX q = generic_coordinates(type);
  const std::optional<joints::Placement> stated = stated_placement(type.name, values, q);
  if (!stated) return;
  const joints::Placement read = compare::referee_motion(type, q).placement;
  const Entry entry = table.entry("type");
  table.ledger().numbers(entry, read.d, stated->d);
  table.ledger().numbers(entry, read.R, stated->R);
  const std::optional<StatedSpeeds> speeds = stated_speeds(type.name, values, stated->R);
  const auto n = static_cast<double>(type.permits_speeds.size());
  table.ledger().number(entry, n, speeds ? speeds->n : 0.0);
  if (!speeds) return;
  for (const joints::PermitSpeed& word : type.permits_speeds) {
    const Vec6 permitted = compare::referee_permitted_speed(word, read.R);
    table.ledger().numbers(entry, speeds->forbidden * permitted, VecX::Zero(speeds->forbidden.rows()), kRoundOff,
                           permitted.norm());
  }
}

}  // namespace

void hold_joint_type(const Joint& joint, const StatedTable& table) {
  const std::string name = table.text("type").value_or("");
  table.ledger().word(table.entry("type"), joint.type->name, name);
  const joints::JointType* stated = joints::find(name);
  if (stated == nullptr) throw std::runtime_error("no joint type " + name);
  Numbers values;
  for (const joints::Parameter& parameter : stated->parameters) values.push_back(table.number(parameter.name).value());
  const joints::JointType by_page = values.empty() ? *stated : stated->with_parameters(values);
  hold_motion(by_page, values, table);
  if (values.empty()) return;
  const std::string key = stated->parameters.size() == 1 ? stated->parameters.front().name : "parameters";
  table.ledger().numbers(table.entry(key), column_of(numbers_of(*joint.type)), column_of(numbers_of(by_page)));
}

}  // namespace concord::second_reading
