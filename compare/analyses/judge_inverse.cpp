#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "compare/analyses/acceleration_scale.h"
#include "compare/analyses/inverse.h"
#include "compare/analyses/judge_steps.h"
#include "compare/audit/digits.h"
#include "compare/report/text_table.h"
#include "compare/verdict/agreement.h"
#include "compare/verdict/align.h"
#include "compare/verdict/chart.h"
#include "compare/verdict/term_sizes.h"

namespace concord::compare::analyses {

namespace {

/// Accelerations of all bodies by the actuated machine, and the loads on them, against those of the driven one.
double round_trip_digits(const Model& model, const State& state, const Evaluation& there, const Evaluation& back) {
  const QuantityLayout layout(model);
  const Series series = align(layout, std::vector<SharedState>{{state, {there, back}}});
  const std::vector<Measured> measured = measure(layout, series);
  const VecX asked = scaled_accelerations(model, there);
  const VecX reached = scaled_accelerations(model, back);
  constexpr double kPartOfSpin = 1e-3;  // of a balanced rotor, on which nothing acts, that is what is left to compare
  double scale = std::max(asked.lpNorm<Eigen::Infinity>(), reference_acceleration(model, state, there));
  for (const BodyState& body : state.bodies) scale = std::max(scale, kPartOfSpin * body.omega.squaredNorm());
  // Where motors hold springs and nothing else acts, asked and reached are round-off of the springs' terms.
  const VecX terms = term_sizes(layout, {state, {there, back}});
  for (std::size_t row = 0; row < measured.size(); ++row) {
    const Quantity& quantity = layout.quantities()[row];
    if (quantity.kind != Kind::acceleration || quantity.component >= 6) continue;
    const double size = kScaleFloor * terms(static_cast<Eigen::Index>(row));
    scale = std::max(scale, quantity.component < 3 ? size / model.length_scale() : size);
  }
  double mass = 0.0;
  for (const Body& body : model.bodies) mass += body.modal ? body.modal->G(0, 0) : body.mass;
  double worst = matching_digits((reached - asked).lpNorm<Eigen::Infinity>(), scale);
  for (std::size_t row = 0; row < measured.size(); ++row) {
    const Kind kind = layout.quantities()[row].kind;
    if (kind != Kind::body_sum && kind != Kind::element) continue;
    // A body at rest between springs has a sum of nothing but round-off: it is held against what accelerates elsewhere.
    const bool is_torque = layout.quantities()[row].component >= 3;
    const double load = mass * scale * model.length_scale() * (is_torque ? model.length_scale() : 1.0);
    worst = std::min(worst, matching_digits(measured[row].difference, std::max(measured[row].scale, load)));
  }
  return worst;
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

  Lines lines{{"driven", "acceleration", "tau by cartesian", "by relative", "unit", "digits"}};
  for (const Prescribed& one : coordinates) {
    const auto tau = [&](Who who) { return force_to_apply(driven, there[index(who)], one); };
    const bool turn = turning_speeds(*model.joints[one.joint].type).at(static_cast<std::size_t>(one.speed(model)));
    // Judged with the joint's wrench as its scale among the other rows; here for the reader.
    const double scale = std::max(std::abs(tau(Who::cartesian)), std::abs(tau(Who::relative)));
    const double digits = matching_digits(tau(Who::cartesian) - tau(Who::relative), scale);
    lines.push_back({one.name(model), fmt::format("{:g}", one.acceleration),
                     fmt::format("{:.12g}", tau(Who::cartesian)), fmt::format("{:.12g}", tau(Who::relative)),
                     turn ? "N m" : "N", format_digits(digits)});
  }
  result.text += "forces that make the machine move as asked:\n" +
                 format_table(lines, {false, true, true, true, false, true}) + '\n';
  for (const Who who : kBothSolvers) {
    const Model actuated = actuated_by(begun, there[index(who)], coordinates);
    for (const Who by : kBothSolvers) {
      const auto solver = (by == Who::cartesian ? makers.cartesian : makers.relative)(actuated);
      const double digits = round_trip_digits(driven, start, there[index(who)], solver->evaluate(start));
      result.numbers.push_back(
          {fmt::format("round trip: forces by {}, accelerations by {}", solvers[index(who)]->name(), solver->name()),
           "",
           {},
           digits,
           kRoundTrip});
      result.text += fmt::format("{}: {} digits\n", result.numbers.back().name, format_digits(digits));
    }
  }
  conclude(result);
  result.driven = std::move(driven);
  return result;
}

}  // namespace concord::compare::analyses
