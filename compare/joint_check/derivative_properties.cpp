#include "compare/joint_check/derivative_properties.h"

#include <fmt/format.h>

#include <algorithm>

namespace concord::compare::joint_check {

namespace {

using cartesian::ConstraintRow;
using cartesian::RelativeMotion;

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

void rows_against_refereed(const EvaluatedPose& evaluated, const std::vector<ConstraintRow>& rows,
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

}  // namespace

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
             [&] { return fmt::format("Sdot u is off by {:.3g} of {:.3g}", error, expected.norm()); });
}

void motion_against_referee(const EvaluatedPose& evaluated, Property& property) {
  const auto note = [&](const char* what, double error, double scale) {
    property.note(error / scale, evaluated.pose.number,
                  [&] { return fmt::format("{} is off by {:.3g}", what, error); });
  };
  const relative::JointMotion& found = evaluated.permitted;
  const joints::FunctionOfCoordinates::Motion& expected = evaluated.referee;
  const Eigen::Index n = evaluated.type.n_u();
  note("d", (found.d - expected.placement.d).norm(), 1.0 + found.d.norm());
  note("R", (found.R - expected.placement.R).norm(), 1.0);
  if (n > 0) note("S", (found.S.leftCols(n) - expected.S.leftCols(n)).norm(), 1.0 + expected.S.norm());
  note("S u", (found.v_rel - expected.S.leftCols(n) * evaluated.pose.u).norm(), evaluated.speed());
  note("Sdot u", (found.Sdot_u - expected.Sdot_u).norm(), evaluated.speed() * evaluated.speed());
}

void rows_against_referee(const EvaluatedPose& evaluated, Property& forbidden, Property& readings) {
  const Vec6& v_rel = evaluated.permitted.v_rel;
  rows_against_refereed(evaluated, evaluated.forbidden, referee_forbids(evaluated.type, evaluated.at, v_rel),
                        forbidden);
  rows_against_refereed(evaluated, evaluated.readings, referee_reads(evaluated.type, evaluated.at, v_rel), readings);
}

}  // namespace concord::compare::joint_check
