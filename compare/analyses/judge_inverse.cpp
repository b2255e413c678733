#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "compare/analyses/inverse.h"
#include "compare/analyses/judge_steps.h"
#include "compare/audit/digits.h"
#include "compare/audit/joint_kinematics.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/machine_size.h"
#include "compare/equilibrium/acceleration_scale.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/report/text_table.h"
#include "compare/resolution/term_sizes.h"
#include "compare/states/chart.h"

namespace concord::compare::analyses {

namespace {

/// What accelerations are held against [1/s2]: those of the bodies, what forces cause, and of what moves though nothing
/// acts on it, as a balanced rotor or a sledge, a part of its speed's square, of which round-off is left.
/// Where motors hold springs and nothing else acts, there is round-off of the springs' terms.
double scale_of(const QuantityLayout& layout, const State& state, const std::array<Evaluation, 2>& found) {
  constexpr double kPartOfSpin = 1e-3;
  constexpr double kPartOfSpeed = 1e-5;
  const Model& model = layout.model();
  const Evaluation& there = found[0];
  double scale = std::max(scaled_accelerations(model, there).lpNorm<Eigen::Infinity>(),
                          reference_acceleration(model, state, there));
  for (const BodyState& body : state.bodies) {
    const double of_speed = body.v.squaredNorm() / (model.length_scale() * model.length_scale());
    scale = std::max({scale, kPartOfSpin * body.omega.squaredNorm(), kPartOfSpeed * of_speed});
  }
  const VecX terms = term_sizes(layout, {state, found});
  for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
    const Quantity& quantity = layout.quantities()[row];
    if (quantity.kind != Kind::acceleration || quantity.component >= 6) continue;
    const double size = kScaleFloor * terms(static_cast<Eigen::Index>(row));
    scale = std::max(scale, quantity.component < 3 ? size / model.length_scale() : size);
  }
  return scale;
}

/// Accelerations of all bodies by the actuated machine, and the loads on them, against those of the driven one.
double round_trip_digits(const Model& model, const State& state, const Evaluation& there, const Evaluation& back) {
  const QuantityLayout layout(model);
  const Series series = align(layout, std::vector<SharedState>{{state, {there, back}}});
  const std::vector<Measured> measured = measure(layout, series);
  const VecX asked = scaled_accelerations(model, there);
  const VecX reached = scaled_accelerations(model, back);
  const double scale = scale_of(layout, state, {there, back});
  const MachineSize size(model);
  double worst = matching_digits((reached - asked).lpNorm<Eigen::Infinity>(), scale);
  for (std::size_t row = 0; row < measured.size(); ++row) {
    const Kind kind = layout.quantities()[row].kind;
    if (kind != Kind::body_sum && kind != Kind::element) continue;
    // A body at rest between springs has a sum of nothing but round-off: it is held against what accelerates elsewhere.
    const bool is_torque = layout.quantities()[row].component >= 3;
    const double load = size.mass * scale * size.length * (is_torque ? size.length : 1.0);
    worst = std::min(worst, matching_digits(measured[row].difference, std::max(measured[row].scale, load)));
  }
  return worst;
}

/// Of the driven coordinates the accelerations that bodies have, read by the third opinion, against those asked for,
/// relative to what accelerations are held against.
NumberRow as_asked(const Model& driven, const State& state, const Evaluation& there,
                   const std::vector<Prescribed>& coordinates, std::string_view solver) {
  const double length = driven.length_scale();
  const double scale = scale_of(QuantityLayout(driven), state, {there, there});
  double worst = kMostDigits;
  for (const Prescribed& one : coordinates) {
    const Joint& joint = driven.joints[one.joint];
    const auto speed = static_cast<std::size_t>(one.speed(driven));
    const VecX udot = joint_accelerations(joint, state, there, state.q[one.joint], length);
    const double unit = turning_speeds(*joint.type).at(speed) ? 1.0 : length;
    const double found = udot(static_cast<Eigen::Index>(speed));
    worst =
        std::min(worst, matching_digits(found - one.acceleration, std::max(scale * unit, std::abs(one.acceleration))));
  }
  return {fmt::format("as asked: accelerations by {}, read from the bodies", solver), "", kNoValues, worst, kAsAsked};
}

/// `size`: of the terms of which the force is the sum. What is round-off of them is held against a part of them.
AppliedForceRow force_row(const Model& model, const Model& driven, const std::array<Evaluation, 2>& there,
                          const Prescribed& one, double size) {
  const std::array<double, 2> tau{force_to_apply(driven, there[0], one), force_to_apply(driven, there[1], one)};
  const bool turns = turning_speeds(*model.joints[one.joint].type).at(static_cast<std::size_t>(one.speed(model)));
  const double scale = std::max({std::abs(tau[0]), std::abs(tau[1]), kScaleFloor * size});
  const double digits = matching_digits(tau[0] - tau[1], scale);
  return {one.name(model), one.acceleration, turns ? "N m" : "N", tau, digits};
}

std::string text_of(const std::vector<AppliedForceRow>& forces) {
  Lines lines{{"driven", "acceleration", "tau by cartesian", "by relative", "unit", "digits"}};
  for (const AppliedForceRow& row : forces) {
    lines.push_back({row.name, fmt::format("{:g}", row.acceleration), fmt::format("{:.12g}", row.tau[0]),
                     fmt::format("{:.12g}", row.tau[1]), row.unit, format_digits(row.digits)});
  }
  return format_table(lines, {false, true, true, true, false, true});
}

bool starts(const SolverMakers& makers, const Model& model) {
  try {
    makers.cartesian(model)->assemble();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

AnalysisVerdict judge_inverse(const Model& model, const SolverMakers& makers,
                              const std::vector<AskedAcceleration>& asked) {
  const std::vector<Prescribed> coordinates = prescribed_coordinates(model, asked);
  AnalysisVerdict result;
  result.analysis = "inverse";
  Model begun = model;
  const State start = make_solvers(begun, makers, result)[index(Who::cartesian)]->assemble();
  Model driven = driven_through(started_at(begun, start), start, coordinates,
                                [&](const Model& candidate) { return starts(makers, candidate); });
  const Solvers solvers = make_solvers(driven, makers, result);
  std::array<Evaluation, 2> there;
  for (const Who who : kBothSolvers) there[index(who)] = solvers[index(who)]->evaluate(start);
  judge_wrenches(driven, solvers, {one_sample(start, there[0]), one_sample(start, there[1])}, Found::motion, result);

  const QuantityLayout layout(driven);
  const VecX terms = term_sizes(layout, {start, there});
  for (const Prescribed& one : coordinates) {
    const int row = layout.row_of({Kind::tau, one.joint, Side::child, one.speed(driven)});
    result.forces.push_back(force_row(model, driven, there, one, terms(row)));
  }
  result.text += "forces that make the machine move as asked:\n" + text_of(result.forces) + '\n';
  for (const Who who : kBothSolvers) {
    result.numbers.push_back(as_asked(driven, start, there[index(who)], coordinates, solvers[index(who)]->name()));
    result.text +=
        fmt::format("{}: {} digits\n", result.numbers.back().name, format_digits(result.numbers.back().digits));
    const Model actuated = actuated_by(begun, there[index(who)], coordinates);
    for (const Who by : kBothSolvers) {
      const auto solver = (by == Who::cartesian ? makers.cartesian : makers.relative)(actuated);
      const double digits = round_trip_digits(driven, start, there[index(who)], solver->evaluate(start));
      result.numbers.push_back(
          {fmt::format("round trip: forces by {}, accelerations by {}", solvers[index(who)]->name(), solver->name()),
           "", kNoValues, digits, kRoundTrip});
      result.text += fmt::format("{}: {} digits\n", result.numbers.back().name, format_digits(digits));
    }
  }
  conclude(result);
  result.machine = std::move(driven);
  return result;
}

}  // namespace concord::compare::analyses
