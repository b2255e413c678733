#include "compare/joint_check/word_properties.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "cartesian/joint_rows.h"
#include "common/decompositions.h"
#include "common/model.h"
#include "common/rotation.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/referee.h"
#include "relative/mobilizer.h"
#include "relative/nonholonomic_constraint.h"

namespace concord::compare::joint_check {

namespace {

using cartesian::ConstraintRow;
using cartesian::RelativeMotion;
using joints::FunctionOfCoordinates;

constexpr double kExact = 13.0;         // digits of what only round-off parts
constexpr double kByDifferences = 8.0;  // digits of a central difference, extrapolated
constexpr double kNearby = 1e-11;       // m, rad: what Newton's method may leave
constexpr double kStep = 1e-3;          // m, rad
constexpr double kIndependent = 0.01;   // least singular value of unit columns that do not depend on each other
constexpr double kDisturbance = 0.15;   // m, rad

Vec6 gradient_of(const ConstraintRow& row) { return (Vec6() << row.over_d, row.over_rho).finished(); }

/// The placement after moving with constant ddot and omega for `time`.
Placement after(const Placement& at, const Vec6& v_rel, double time) {
  const Vec3 omega = v_rel.tail<3>();
  const double speed = omega.norm();
  const Mat3 turned = speed > 0.0 ? rotation_about(Vec3(omega / speed), speed * time) : Mat3(Mat3::Identity());
  return {at.d + time * v_rel.head<3>(), turned * at.R};
}

RelativeMotion relative_motion(const Placement& at, const Vec6& v_rel) {
  return {at.d, at.R, v_rel.head<3>(), v_rel.tail<3>()};
}

std::vector<ConstraintRow> forbids(const JointType& type, const RelativeMotion& motion) {
  std::vector<ConstraintRow> rows(cartesian::kMaxRows);
  rows.resize(cartesian::evaluate_forbids(type, motion, rows.data()));
  return rows;
}

/// One row for each speed: the readings, and of an orientation the three rows of its distance from `target`.
std::vector<ConstraintRow> reads(const JointType& type, const RelativeMotion& motion, const Mat3& target) {
  std::vector<ConstraintRow> rows;
  for (const joints::Read& word : type.reads) {
    if (std::holds_alternative<joints::OrientationOf>(word)) {
      rows.resize(rows.size() + 3);
      cartesian::evaluate_orientation(target, motion, &rows[rows.size() - 3]);
      continue;
    }
    for (int c = 0; c < cartesian::n_speeds(word); ++c) rows.push_back(cartesian::evaluate_read(word, c, motion));
  }
  return rows;
}

/// Change of an angle or of a length.
double change(double from, double to, bool is_turn) {
  return is_turn ? std::remainder(to - from, 2.0 * std::numbers::pi) : to - from;
}

/// Derivative at zero of a function of one variable: central differences of two step lengths, extrapolated.
template <class Function>
auto differentiate(const Function& f) {
  using Value = std::decay_t<decltype(f(0.0))>;
  const Value fine = (f(kStep) - f(-kStep)) / (2.0 * kStep);
  const Value coarse = (f(2.0 * kStep) - f(-2.0 * kStep)) / (4.0 * kStep);
  return Value((4.0 * fine - coarse) / 3.0);
}

Vec6 rotation_and_displacement(const Placement& from, const Placement& to) {
  const Eigen::AngleAxisd turned(Mat3(to.R * from.R.transpose()));
  Vec6 step;
  step << to.d - from.d, turned.angle() * turned.axis();
  return step;
}

/// A joint type evaluated at one pose by all who know it: both solvers and the referee.
struct EvaluatedPose {
  EvaluatedPose(const JointType& of, const MotionPose& pose_of)
      : type(of), pose(pose_of), words(of), referee(referee_permits(of, pose.q, pose.u)) {
    words.evaluate(pose.q.data(), pose.u.data(), permitted);
    at = {permitted.d, permitted.R};
    motion = relative_motion(at, permitted.v_rel);
    forbidden = forbids(type, motion);
    readings = reads(type, motion, permitted.R);
  }

  /// The motion with other coordinates: moved by `step` along the speeds.
  [[nodiscard]] relative::JointMotion moved(const VecX& step) const {
    VecX q = pose.q;
    words.advance(q.data(), step.data());
    relative::JointMotion reached;
    words.evaluate(q.data(), pose.u.data(), reached);
    return reached;
  }

  [[nodiscard]] MatX S() const { return permitted.S.leftCols(type.n_u()); }
  [[nodiscard]] double speed() const { return 1.0 + permitted.v_rel.norm(); }

  const JointType& type;
  const MotionPose& pose;
  relative::Mobilizer words;
  relative::JointMotion permitted;
  FunctionOfCoordinates::Motion referee;
  Placement at;
  RelativeMotion motion;
  std::vector<ConstraintRow> forbidden;
  std::vector<ConstraintRow> readings;
};

auto in_words(const char* format, double a, double b) {
  return [=] { return fmt::format(fmt::runtime(format), a, b); };
}

auto in_row(const char* kind, std::size_t row, double found, double expected) {
  return [=] { return fmt::format("{} {}: {:.12g}, expected {:.12g}", kind, row + 1, found, expected); };
}

// The statements against each other ----------------------------------------------------------------------------------

void motion_turns_by_a_rotation(const EvaluatedPose& evaluated, Property& property) {
  const Mat3& R = evaluated.permitted.R;
  const double error = (R.transpose() * R - Mat3::Identity()).norm() + std::abs(R.determinant() - 1.0);
  property.note(error, evaluated.pose.number,
                in_words("R^T R is {:.3g} off 1 (determinant {:.6g})", error, R.determinant()));
}

void motion_is_forbidden_by_nothing(const EvaluatedPose& evaluated, Property& property) {
  property.require(cartesian::on_branch(evaluated.type, evaluated.motion), evaluated.pose.number,
                   [] { return "a permitted placement is not on the branch that is meant"; });
  for (std::size_t k = 0; k < evaluated.forbidden.size(); ++k) {
    property.note(evaluated.forbidden[k].value, evaluated.pose.number,
                  in_row("row", k, evaluated.forbidden[k].value, 0.0));
  }
}

void permitted_speeds_are_not_forbidden(const EvaluatedPose& evaluated, Property& property) {
  for (std::size_t k = 0; k < evaluated.forbidden.size(); ++k) {
    const VecX work = evaluated.S().transpose() * gradient_of(evaluated.forbidden[k]);
    const double error = work.size() > 0 ? work.lpNorm<Eigen::Infinity>() : 0.0;
    property.note(error, evaluated.pose.number, in_row("row", k, error, 0.0));
  }
}

void permitted_accelerations_are_not_forbidden(const EvaluatedPose& evaluated, Property& property) {
  const double scale = evaluated.speed() * evaluated.speed();
  for (std::size_t k = 0; k < evaluated.forbidden.size(); ++k) {
    const double found =
        gradient_of(evaluated.forbidden[k]).dot(evaluated.permitted.Sdot_u) + evaluated.forbidden[k].bias;
    property.note(found / scale, evaluated.pose.number, in_row("row", k, found, 0.0));
  }
}

void both_sets_fill_space(const EvaluatedPose& evaluated, Property& property) {
  const auto rows = static_cast<Eigen::Index>(evaluated.forbidden.size());
  MatX directions(6, rows + evaluated.type.n_u());
  for (Eigen::Index k = 0; k < rows; ++k) directions.col(k) = gradient_of(evaluated.forbidden[k]);
  directions.rightCols(evaluated.type.n_u()) = evaluated.S();
  directions.colwise().normalize();
  const double least = singular_values(directions).minCoeff();
  property.require(
      least > kIndependent, evaluated.pose.number,
      in_words("least singular value {:.3g} of unit columns, more than {:g} expected", least, kIndependent));
}

/// The nearest placement to `from` where nothing is forbidden, by Newton's method with the shortest steps.
std::optional<Placement> nearest_allowed(const JointType& type, Placement from) {
  constexpr int kMostSteps = 50;
  for (int step = 0; step < kMostSteps; ++step) {
    const std::vector<ConstraintRow> rows = forbids(type, relative_motion(from, Vec6::Zero()));
    const auto n = static_cast<Eigen::Index>(rows.size());
    MatX G(n, 6);
    VecX values(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      G.row(k) = gradient_of(rows[k]).transpose();
      values(k) = rows[k].value;
    }
    const Vec6 correction = -smallest_least_squares(G, values);
    from = after(from, correction, 1.0);
    if (correction.norm() < 1e-14) return from;
  }
  return std::nullopt;
}

/// Coordinates as they read from a placement; turns in (-pi, pi].
VecX read_q(const JointType& type, const Placement& at) {
  const RelativeMotion motion = relative_motion(at, Vec6::Zero());
  VecX q(type.n_q());
  Eigen::Index place = 0;
  for (const joints::Read& word : type.reads) {
    if (std::holds_alternative<joints::OrientationOf>(word)) {
      const Eigen::Quaterniond turned(at.R);
      q.segment<4>(place) << turned.w(), turned.vec();
      place += 4;
      continue;
    }
    for (int c = 0; c < cartesian::n_speeds(word); ++c) q(place++) = cartesian::evaluate_read(word, c, motion).value;
  }
  return q;
}

void nothing_else_nearby_is_allowed(const EvaluatedPose& evaluated, Property& property) {
  if (evaluated.type.rows() == 0) return;
  Numbers numbers(static_cast<std::uint32_t>(evaluated.pose.number), streams::kFirstDisturbance);
  for (int trial = 0; trial < 4; ++trial) {
    Vec6 away;
    away << numbers.vector(kDisturbance), numbers.vector(kDisturbance);
    const std::optional<Placement> found = nearest_allowed(evaluated.type, after(evaluated.at, away, 1.0));
    property.require(found.has_value(), evaluated.pose.number,
                     [] { return "Newton's method on what is forbidden does not come back from nearby"; });
    if (!found || !cartesian::on_branch(evaluated.type, relative_motion(*found, Vec6::Zero()))) continue;
    const VecX still = VecX::Zero(evaluated.type.n_u());
    const FunctionOfCoordinates::Motion permitted =
        referee_permits(evaluated.type, read_q(evaluated.type, *found), still);
    const double error = rotation_and_displacement(permitted.placement, *found).norm();
    property.require(error < kNearby, evaluated.pose.number,
                     in_words("a placement where nothing is forbidden is {:.3g} (m, rad) away from the permitted one "
                              "that has its coordinates; at most {:g} expected",
                              error, kNearby));
  }
}

void coordinates_read_back(const EvaluatedPose& evaluated, Property& property) {
  const std::vector<Coordinate> coordinates = coordinates_of(evaluated.type);
  for (const Coordinate& coordinate : coordinates) {
    const double expected = evaluated.pose.q(coordinate.q);
    const double found = evaluated.readings[coordinate.u].value;
    const double error = change(expected, found, coordinate.is_turn);
    property.note(error / (1.0 + std::abs(expected)), evaluated.pose.number,
                  in_row("coordinate", coordinate.u, found, expected));
  }
  const FunctionOfCoordinates::Motion again =
      referee_permits(evaluated.type, read_q(evaluated.type, evaluated.at), evaluated.pose.u);
  const double error = rotation_and_displacement(evaluated.at, again.placement).norm();
  property.note(error / 10.0, evaluated.pose.number,
                in_words("the coordinates read lead to a placement {:.3g} (m, rad) away", error, 0.0));
}

void rates_of_readings_are_the_speeds(const EvaluatedPose& evaluated, Property& property) {
  for (std::size_t k = 0; k < evaluated.readings.size(); ++k) {
    const double found = gradient_of(evaluated.readings[k]).dot(evaluated.permitted.v_rel);
    const double expected = evaluated.pose.u(static_cast<Eigen::Index>(k));
    property.note((found - expected) / evaluated.speed(), evaluated.pose.number, in_row("speed", k, found, expected));
    const double at_rest =
        gradient_of(evaluated.readings[k]).dot(evaluated.permitted.Sdot_u) + evaluated.readings[k].bias;
    property.note(at_rest / (evaluated.speed() * evaluated.speed()), evaluated.pose.number,
                  in_row("acceleration at constant speed of coordinate", k, at_rest, 0.0));
  }
}

void note_difference(Property& property, const EvaluatedPose& evaluated, const char* what, std::size_t row,
                     double found, double expected, double scale) {
  property.note((found - expected) / scale, evaluated.pose.number,
                [&] { return fmt::format("{} {}: {:.12g}, expected {:.12g}", what, row + 1, found, expected); });
}

std::vector<ConstraintRow> forbidden_speeds(const JointType& type, const RelativeMotion& motion) {
  std::vector<ConstraintRow> rows(cartesian::kMaxRows);
  rows.resize(cartesian::evaluate_forbidden_speeds(type, motion, rows.data()));
  return rows;
}

/// S of the speeds that are possible, 6 x n, as the third opinion reads them from what the page permits.
MatX possible(const EvaluatedPose& evaluated) {
  return evaluated.S() * free_speeds(evaluated.type, evaluated.at.R, evaluated.S());
}

void possible_velocities_do_not_slip(const EvaluatedPose& evaluated, Property& property) {
  const std::vector<ConstraintRow> rows = forbidden_speeds(evaluated.type, evaluated.motion);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double error = (possible(evaluated).transpose() * gradient_of(rows[k])).lpNorm<Eigen::Infinity>();
    property.note(error, evaluated.pose.number, in_row("row", k, error, 0.0));
  }
}

/// What a page permits of velocities is what its motion permits, less what it forbids of velocities: nothing is lost.
void velocities_fill_space(const EvaluatedPose& evaluated, Property& property) {
  if (evaluated.type.nonholonomic_rows() == 0) return;
  MatX directions(6, 6);
  Eigen::Index column = 0;
  for (const ConstraintRow& row : evaluated.forbidden) directions.col(column++) = gradient_of(row);
  for (const ConstraintRow& row : forbidden_speeds(evaluated.type, evaluated.motion))
    directions.col(column++) = gradient_of(row);
  directions.rightCols(6 - column) = possible(evaluated);
  directions.colwise().normalize();
  const double least = singular_values(directions).minCoeff();
  property.require(
      least > kIndependent, evaluated.pose.number,
      in_words("least singular value {:.3g} of unit columns, more than {:g} expected", least, kIndependent));
}

/// The relative solver's rows on the speeds, from what is permitted, against the Cartesian ones, from what is
/// forbidden: the same velocities, and the same accelerations.
void solvers_forbid_the_same_speeds(const EvaluatedPose& evaluated, Property& property) {
  if (evaluated.type.nonholonomic_rows() == 0) return;
  relative::NonholonomicConstraint permitted(evaluated.type, evaluated.words);
  permitted.evaluate(evaluated.permitted, evaluated.type.name);
  const MatX C = permitted.C().leftCols(permitted.n_rows());
  const MatX free = free_speeds(evaluated.type, evaluated.at.R, evaluated.S());
  const double error = (C.transpose() * free).lpNorm<Eigen::Infinity>() / free.norm();
  property.note(error, evaluated.pose.number,
                in_words("a velocity that is permitted slips by {:.3g} in relative, {:g} expected", error, 0.0));
  const VecX udot = -C * solve_by_complete_pivoting(C.transpose() * C, permitted.bias().head(permitted.n_rows()));
  const Vec6 a_rel = evaluated.S() * udot + evaluated.permitted.Sdot_u;
  const std::vector<ConstraintRow> rows = forbidden_speeds(evaluated.type, evaluated.motion);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double found = gradient_of(rows[k]).dot(a_rel) + rows[k].bias;
    property.note(found / (evaluated.speed() * evaluated.speed()), evaluated.pose.number,
                  in_row("acceleration of row", k, found, 0.0));
  }
}

/// gamma of what is forbidden of velocities alone, by differences of the rows' rates.
void rates_of_forbidden_speeds(const EvaluatedPose& evaluated, Property& property) {
  const Vec6& v_rel = evaluated.permitted.v_rel;
  const std::vector<ConstraintRow> rows = forbidden_speeds(evaluated.type, evaluated.motion);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double expected = differentiate([&](double h) {
      const RelativeMotion later = relative_motion(after(evaluated.at, v_rel, h), v_rel);
      return gradient_of(forbidden_speeds(evaluated.type, later)[k]).dot(v_rel);
    });
    note_difference(property, evaluated, "row", k, rows[k].bias, expected, evaluated.speed() * evaluated.speed());
  }
}

void coordinate_wrenches_work_on_their_coordinate(const EvaluatedPose& evaluated, Property& property) {
  VecX tau = VecX::Zero(evaluated.type.n_u());
  for (Eigen::Index k = 0; k < tau.size(); ++k) {
    tau.setZero();
    tau(k) = 1.0;
    const Vec6 expected = referee_coordinate_wrench(evaluated.type, evaluated.referee, tau);
    const VecX work = evaluated.referee.S.leftCols(tau.size()).transpose() * expected;
    const double scale = std::max(1.0, expected.norm());
    const auto note = [&](const char* who, double error) {
      property.note(error / scale, evaluated.pose.number,
                    [&] { return fmt::format("coordinate {}, {}: off by {:.3g}", k + 1, who, error); });
    };
    note("work by the referee", (work - tau).norm());
    note("cartesian", (cartesian::coordinate_wrench(evaluated.type, evaluated.motion, tau) - expected).norm());
    note("relative", (evaluated.words.coordinate_wrench(evaluated.permitted, tau) - expected).norm());
  }
}

// Derivatives by differences -----------------------------------------------------------------------------------------

template <class RowsAt>
void rows_by_differences(const EvaluatedPose& evaluated, const std::vector<ConstraintRow>& rows, const RowsAt& rows_at,
                         const std::vector<bool>& wraps, Property& jacobian, Property& gamma) {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    for (int c = 0; c < 6; ++c) {
      const double expected = differentiate([&](double h) {
        const double value = rows_at(relative_motion(after(evaluated.at, Vec6::Unit(c), h), Vec6::Zero()))[k].value;
        return change(rows[k].value, value, wraps[k]);
      });
      note_difference(jacobian, evaluated, "row", k, gradient_of(rows[k])(c), expected,
                      1.0 + gradient_of(rows[k]).norm());
    }
    const double expected = differentiate([&](double h) {
      const ConstraintRow later =
          rows_at(relative_motion(after(evaluated.at, evaluated.permitted.v_rel, h), evaluated.permitted.v_rel))[k];
      return gradient_of(later).dot(evaluated.permitted.v_rel);
    });
    note_difference(gamma, evaluated, "row", k, rows[k].bias, expected,
                    evaluated.speed() * evaluated.speed() * (1.0 + gradient_of(rows[k]).norm()));
  }
}

/// What is forbidden, then what reads.
void rows_against_differences(const EvaluatedPose& evaluated, Property* properties) {
  const std::vector<bool> straight(evaluated.forbidden.size(), false);
  rows_by_differences(
      evaluated, evaluated.forbidden, [&](const RelativeMotion& motion) { return forbids(evaluated.type, motion); },
      straight, properties[0], properties[1]);
  std::vector<bool> wraps(evaluated.readings.size(), false);
  for (const Coordinate& coordinate : coordinates_of(evaluated.type)) wraps[coordinate.u] = coordinate.is_turn;
  rows_by_differences(
      evaluated, evaluated.readings,
      [&](const RelativeMotion& motion) { return reads(evaluated.type, motion, evaluated.at.R); }, wraps, properties[2],
      properties[3]);
}

void motion_against_differences(const EvaluatedPose& evaluated, Property& columns, Property& rates) {
  for (int c = 0; c < evaluated.type.n_u(); ++c) {
    const VecX direction = VecX::Unit(evaluated.type.n_u(), c);
    const Vec6 expected = differentiate([&](double h) {
      const relative::JointMotion reached = evaluated.moved(h * direction);
      return rotation_and_displacement(evaluated.at, {reached.d, reached.R});
    });
    const Vec6 found = evaluated.permitted.S.col(c);
    columns.note((found - expected).norm() / (1.0 + expected.norm()), evaluated.pose.number,
                 [&] { return fmt::format("column {} is off by {:.3g}", c + 1, (found - expected).norm()); });
  }
  const Vec6 expected = differentiate([&](double h) { return evaluated.moved(h * evaluated.pose.u).v_rel; });
  const double error = (evaluated.permitted.Sdot_u - expected).norm();
  rates.note(error / (evaluated.speed() * evaluated.speed()), evaluated.pose.number,
             in_words("Sdot u is off by {:.3g} of {:.3g}", error, expected.norm()));
}

// Derivatives by the referee -----------------------------------------------------------------------------------------

void rows_against_referee(const EvaluatedPose& evaluated, const std::vector<ConstraintRow>& rows,
                          const std::vector<RefereedRow>& refereed, Property& property) {
  property.require(rows.size() == refereed.size(), evaluated.pose.number,
                   [&] { return fmt::format("{} rows, {} expected", rows.size(), refereed.size()); });
  for (std::size_t k = 0; k < std::min(rows.size(), refereed.size()); ++k) {
    const double scale = 1.0 + refereed[k].gradient.norm();
    property.note((gradient_of(rows[k]) - refereed[k].gradient).norm() / scale, evaluated.pose.number, [&] {
      return fmt::format("gradient of row {} is off by {:.3g}", k + 1,
                         (gradient_of(rows[k]) - refereed[k].gradient).norm());
    });
    note_difference(property, evaluated, "bias of row", k, rows[k].bias, refereed[k].bias,
                    scale * evaluated.speed() * evaluated.speed());
  }
}

void motion_against_referee(const EvaluatedPose& evaluated, Property& property) {
  const auto note = [&](const char* what, double error, double scale) {
    property.note(error / scale, evaluated.pose.number,
                  [&] { return fmt::format("{} is off by {:.3g}", what, error); });
  };
  const relative::JointMotion& found = evaluated.permitted;
  const FunctionOfCoordinates::Motion& expected = evaluated.referee;
  const Eigen::Index n = evaluated.type.n_u();
  note("d", (found.d - expected.placement.d).norm(), 1.0 + found.d.norm());
  note("R", (found.R - expected.placement.R).norm(), 1.0);
  if (n > 0) note("S", (found.S.leftCols(n) - expected.S.leftCols(n)).norm(), 1.0 + expected.S.norm());
  note("S u", (found.v_rel - expected.S.leftCols(n) * evaluated.pose.u).norm(), evaluated.speed());
  note("Sdot u", (found.Sdot_u - expected.Sdot_u).norm(), evaluated.speed() * evaluated.speed());
}

struct PropertyCheck {
  const char* name;
  std::optional<double> need;
  void (*check)(const EvaluatedPose&, Property&);
};

const std::vector<PropertyCheck>& single_checks() {
  static const std::vector<PropertyCheck> checks{
      {"the permitted motion turns the child by a rotation", kExact, motion_turns_by_a_rotation},
      {"the permitted motion is forbidden by nothing", kExact, motion_is_forbidden_by_nothing},
      {"permitted speeds and forbidden directions are orthogonal", kExact, permitted_speeds_are_not_forbidden},
      {"the permitted motion's accelerations are not forbidden", kExact, permitted_accelerations_are_not_forbidden},
      {"both together have full rank, away from singular poses", {}, both_sets_fill_space},
      {"coordinates read back from the permitted motion", kExact, coordinates_read_back},
      {"their rates read back too", kExact, rates_of_readings_are_the_speeds},
      {"nothing else nearby is allowed", {}, nothing_else_nearby_is_allowed},
      {"each coordinate's wrench works on it alone, by both solvers", kExact,
       coordinate_wrenches_work_on_their_coordinate},
      {"velocities: what is permitted does not slip", kExact, possible_velocities_do_not_slip},
      {"velocities: permitted and forbidden ones have full rank", {}, velocities_fill_space},
      {"velocities: both solvers forbid the same, and its accelerations", kExact, solvers_forbid_the_same_speeds},
      {"velocities: gamma of what is forbidden, by differences", kByDifferences, rates_of_forbidden_speeds},
  };
  return checks;
}

// The numbers of a statement -----------------------------------------------------------------------------------------

std::string rows_and_speeds(const JointType& type) {
  const auto permitted = static_cast<int>(type.permits_speeds.size());
  if (type.nonholonomic_rows() + permitted > 0 && type.rows() + type.nonholonomic_rows() + permitted != 6) {
    return fmt::format(
        "{} rows are forbidden, {} of velocities alone, and {} velocities permitted; together they must be 6",
        type.rows(), type.nonholonomic_rows(), permitted);
  }
  if (type.rows() + type.n_u() == 6) return {};
  return fmt::format("{} rows are forbidden and {} speeds permitted; together they must be 6", type.rows(), type.n_u());
}

std::string readings_beside_words(const JointType& type) {
  std::vector<int> of_motion;
  for (const joints::Permit& word : type.permits) {
    if (n_q(word) > 0) of_motion.push_back(n_u(word));
  }
  std::vector<int> of_reading;
  for (const joints::Read& word : type.reads) of_reading.push_back(cartesian::n_speeds(word));
  if (of_motion == of_reading) return {};
  return fmt::format("the words of the motion have {} speeds, the readings beside them {}; they must be the same",
                     fmt::join(of_motion, ", "), fmt::join(of_reading, ", "));
}

std::string order_of_words(const JointType& type) {
  try {
    const relative::Mobilizer motion(type);
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

/// What a motion by functions must say of each of its coordinates.
std::string words_by_functions(const JointType& type) {
  for (const joints::Permit& word : type.permits) {
    const auto* by = std::get_if<joints::ByMotion>(&word);
    if (by == nullptr) continue;
    const auto n = static_cast<std::size_t>(by->motion->n());
    if (by->turns.size() != n || by->names.size() != n || (!by->ranges.empty() && by->ranges.size() != n)) {
      return fmt::format("the motion has {} coordinates, but {} turns, {} names and {} ranges", n, by->turns.size(),
                         by->names.size(), by->ranges.size());
    }
    const auto* reading = type.reads.size() == 1 ? std::get_if<joints::ByReading>(&type.reads.front()) : nullptr;
    if (reading == nullptr) return "a motion by functions needs one reading by functions";
    if (reading->turns != by->turns) return "motion and reading differ in which coordinates are turns";
    if (reading->wrenches == nullptr) return "the reading states no coordinate wrenches";
    const VecX q = PoseSource(type, 0).pose(0).q;
    const joints::Wrenches said = reading->wrenches(referee_permits(type, q, VecX::Zero(type.n_u())).placement);
    if (said.cols() != by->motion->n()) {
      return fmt::format("{} coordinate wrenches for {} coordinates", said.cols(), n);
    }
  }
  return {};
}

}  // namespace

Properties check_statement(const JointType& type) {
  Properties properties;
  const auto check = [&](const char* name, std::string (*complaint_about)(const JointType&)) {
    // A statement that is wrong in one way is not looked at in the next.
    if (!properties.empty() && !properties.back().holds()) return;
    const std::string complaint = complaint_about(type);
    properties.emplace_back(name, std::nullopt).require(complaint.empty(), -1, [&] { return complaint; });
  };
  check("rows and speeds are six together", rows_and_speeds);
  check("every coordinate has its reading", readings_beside_words);
  check("words stand in an order that has a meaning", order_of_words);
  check("functions say all that is asked of them", words_by_functions);
  return properties;
}

Properties check_words(const JointType& type, std::uint32_t seed, const std::vector<int>& poses) {
  Properties properties;
  for (const PropertyCheck& one : single_checks()) properties.emplace_back(one.name, one.need);
  const std::size_t differences = properties.size();
  for (const char* name : {"Jacobian of what is forbidden, by differences", "its gamma, by differences",
                           "Jacobian of the readings, by differences", "their gamma, by differences",
                           "motion columns S, by differences", "their rates Sdot u, by differences"}) {
    properties.emplace_back(name, kByDifferences);
  }
  const std::size_t referee = properties.size();
  for (const char* name : {"what is forbidden, by automatic differentiation", "readings, by automatic differentiation",
                           "motion, S and Sdot u, by automatic differentiation"}) {
    properties.emplace_back(name, kExact);
  }
  const PoseSource source(type, seed);
  for (const int number : poses) {
    const MotionPose pose = source.pose(number);
    const EvaluatedPose evaluated(type, pose);
    for (std::size_t k = 0; k < single_checks().size(); ++k) single_checks()[k].check(evaluated, properties[k]);
    rows_against_differences(evaluated, &properties[differences]);
    motion_against_differences(evaluated, properties[differences + 4], properties[differences + 5]);
    rows_against_referee(evaluated, evaluated.forbidden, referee_forbids(type, evaluated.at, evaluated.permitted.v_rel),
                         properties[referee]);
    rows_against_referee(evaluated, evaluated.readings, referee_reads(type, evaluated.at, evaluated.permitted.v_rel),
                         properties[referee + 1]);
    motion_against_referee(evaluated, properties[referee + 2]);
  }
  return properties;
}

}  // namespace concord::compare::joint_check
