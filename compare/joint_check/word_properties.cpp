#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "common/decompositions.h"
#include "compare/audit/joint_motion.h"
#include "compare/joint_check/derivative_properties.h"
#include "compare/joint_check/evaluated_pose.h"
#include "compare/joint_check/type_properties.h"
#include "relative/closure/nonholonomic_constraint.h"

namespace concord::compare::joint_check {

namespace {

using cartesian::ConstraintRow;
using cartesian::RelativeMotion;
using joints::FunctionOfCoordinates;
using joints::Placement;

constexpr double kExact = 13.0;         // digits of what only round-off parts
constexpr double kByDifferences = 8.0;  // digits of a central difference, extrapolated
constexpr double kNearby = 1e-11;       // m, rad: what Newton's method may leave
constexpr double kIndependent = 0.01;   // least singular value of unit columns that do not depend on each other
constexpr double kDisturbance = 0.15;   // m, rad

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
    if (is_orientation(word)) {
      const Eigen::Quaterniond turned(at.R);
      q.segment<4>(place) << turned.w(), turned.vec();
      place += 4;
      continue;
    }
    for (int c = 0; c < n_u(word); ++c) q(place++) = cartesian::evaluate_read(word, c, motion).value;
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

}  // namespace

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
    rows_against_referee(evaluated, properties[referee], properties[referee + 1]);
    motion_against_referee(evaluated, properties[referee + 2]);
  }
  return properties;
}

}  // namespace concord::compare::joint_check
