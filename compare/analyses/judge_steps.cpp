#include "compare/analyses/judge_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "compare/analyses/stretched_beams.h"
#include "compare/audit/balance.h"
#include "compare/audit/digits.h"
#include "compare/audit/geometric_stiffness.h"
#include "compare/quantities/align.h"
#include "compare/quantities/motions.h"
#include "compare/resolution/term_sizes.h"
#include "compare/states/draws.h"
#include "compare/states/states.h"
#include "compare/verdict/judge.h"
#include "compare/verdict/redundant.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/same_state.h"

namespace concord::compare::analyses {

Solvers make_solvers(Model& model, const SolverMakers& makers, AnalysisVerdict& result) {
  std::string note;
  Solvers solvers = make_solvers_on_one_branch(model, makers, note);
  if (!note.empty()) result.text += "note: " + note + '\n';
  return solvers;
}

Found kind_of(const Rests& rests) { return rests.found[0].free.empty() ? Found::rest : Found::neutral_rest; }

namespace {

/// A row for each quantity; of a machine at rest, for all but accelerations. What each solver finds for itself has a
/// need of its own, whatever the model says of runs.
void make_rows_of(const QuantityLayout& layout, bool at_rest, AnalysisVerdict& result) {
  Verdict& verdict = result.wrenches;
  make_rows(layout, verdict);
  if (at_rest) {
    std::erase_if(verdict.others, [](const QuantityRow& row) { return row.quantity.kind == Kind::acceleration; });
  }
  result.own_need = own_need(layout.model());
  for (auto* rows : {&verdict.rows, &verdict.others}) {
    for (QuantityRow& row : *rows) row.need.same_run = result.own_need;
  }
}

/// The largest force and torque that the solvers add up in a machine at rest, those of springs that balance each other
/// too.
struct LargestTerms {
  double force = 0.0;
  double torque = 0.0;

  LargestTerms(const QuantityLayout& layout, const SharedState& rest) {
    const VecX sizes = term_sizes(layout, rest);
    for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
      const Quantity& quantity = layout.quantities()[row];
      if (quantity.kind != Kind::total) continue;
      double& largest = quantity.component < 3 ? force : torque;
      largest = std::max(largest, sizes(static_cast<Eigen::Index>(row)));
    }
    const double length = layout.model().length_scale();
    force = std::max(force, torque / length);
    torque = std::max(torque, force * length);
  }

  [[nodiscard]] double of(const Model& model, const Quantity& quantity) const {
    if (quantity.kind != Kind::coupling) return unit_of(model, quantity) == "N m" ? torque : force;
    double size = 0.0;
    for (const CouplingTerm& term : model.couplings[static_cast<std::size_t>(quantity.owner)].terms)
      size = std::max(size, (is_turn(model, term) ? torque : force) / std::abs(term.factor));
    return size;
  }
};

/// A wrench that vanishes where each solver rests follows from the places that they found, to as many digits: it is
/// held against the machine's largest.
void hold_vanishing_against_machine(const QuantityLayout& layout, const SharedState& rest, std::vector<Measured>& own) {
  const LargestTerms terms(layout, rest);
  for (std::size_t row = 0; row < own.size(); ++row) {
    Measured& one = own[row];
    const Quantity& quantity = layout.quantities()[row];
    if (quantity.kind == Kind::acceleration) continue;
    const double largest = terms.of(layout.model(), quantity);
    if (one.source != ScaleSource::floor && one.scale > kScaleFloor * largest) continue;
    one.scale = std::max(one.machine, largest);
    one.digits = matching_digits(one.difference, one.scale);
    one.unexplained_digits = matching_digits(one.unexplained, one.scale);
  }
}

/// The state with every mode moved by at most as much as moves a place by round-off.
State with_modes_within_round_off(State state, const MachineSize& sizes, Draws& draws) {
  const double round_off = std::numeric_limits<double>::epsilon() * sizes.place;
  for (std::size_t i = 1; i < state.bodies.size(); ++i) {
    VecX& a = state.bodies[i].a;
    for (Eigen::Index mode = 0; mode < a.size(); ++mode) {
      const double step = round_off * draws.next();
      if (sizes.shapes[i](mode) > 0.0) a(mode) += step / sizes.shapes[i](mode);
    }
  }
  return state;
}

/// A search ends where places are those of the rest within round-off, and so are modes, by what they move: a stiff one
/// in a loop then carries a force that is round-off of places. Adds to the resolution how far that moves what a solver
/// answers in the state that it found.
void resolve_as_places_are(const QuantityLayout& layout, const Solvers& solvers, const std::array<Trajectory, 2>& found,
                           MatX& resolution) {
  constexpr std::uint64_t kOfModes = 6;
  for (const Who who : kBothSolvers) {
    const Sample& rest = found[index(who)].samples.front();
    const MachineSize sizes(layout.model(), rest.state);
    Draws draws(kSeed + kOfModes);
    for (int draw = 0; draw < kDraws; ++draw) {
      const State moved = with_modes_within_round_off(rest.state, sizes, draws);
      const auto answer = evaluation_unless_refused(*solvers[index(who)], moved);
      if (!answer) continue;
      const Series series = align(layout, std::vector<SharedState>{{moved, {rest.evaluation, *answer}}});
      resolution.col(0) = resolution.col(0).cwiseMax((series.values[1] - series.values[0]).cwiseAbs().col(0));
    }
  }
}

void leave_out_global_axes(const QuantityLayout& layout, Mask& mask) {
  for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
    const Kind kind = layout.quantities()[row].kind;
    if (kind == Kind::reaction_global || kind == Kind::body_sum) mask.row(static_cast<Eigen::Index>(row)) = false;
  }
}

AuditReport audit(const Model& model, const Trajectory& found) {
  Auditor auditor(model);
  for (const Sample& sample : found.samples) auditor.add(sample.state, sample.evaluation);
  return auditor.report();
}

}  // namespace

void judge_wrenches(const Model& model, const Solvers& solvers, const std::array<Trajectory, 2>& found, Found kind,
                    AnalysisVerdict& result) {
  const bool at_rest = kind != Found::motion;
  Verdict& verdict = result.wrenches;
  const QuantityLayout layout(model);
  const std::array<Solver*, 2> both{solvers[0].get(), solvers[1].get()};
  const std::array<const Trajectory*, 2> trajectories{&found[0], &found[1]};
  Judge judge(layout, {Check::same_state, Check::same_run}, verdict);
  judge.describe(both);
  for (const Who who : kBothSolvers) {
    verdict.solvers[index(who)].rank = both[index(who)]->rank(found[index(who)].samples.front().state);
  }
  make_rows_of(layout, at_rest, result);

  SameState same_state(layout, both, kSeed, judge, verdict);
  const std::vector<Measured> of_states = same_state.judge_states(share(both, run_states(trajectories)));
  if (!same_state.weighed().states.empty()) judge_redundant(layout, same_state.weighed(), of_states, verdict);

  const auto samples = static_cast<int>(found[0].samples.size());
  WeighedRun own = weigh_run(same_state.weighed(), samples);
  if (kind == Found::neutral_rest) leave_out_global_axes(layout, own.mask);
  if (at_rest && model.is_flexible()) resolve_as_places_are(layout, solvers, found, own.resolution);
  const Series series = align(layout, trajectories, samples);
  std::vector<Measured> measured = measure(layout, series, own.budget());
  if (at_rest) {
    const Sample& rest = found[0].samples.front();
    hold_vanishing_against_machine(layout, {rest.state, {rest.evaluation, rest.evaluation}}, measured);
  }
  record(layout, measured, Check::same_run, verdict);
  judge.find_differences_on(series, measured, Check::same_run);
  verdict.motion = compare_motions(model, trajectories);
  verdict.unique = own.mask;

  for (const Who who : kBothSolvers) judge.judge_audit(who, audit(model, found[index(who)]));
  judge.judge_rows();
  Trajectory stretched;
  for (const Sample& sample : found[0].samples) {
    stretched.samples.push_back(with_beams_stretched(model, *solvers[0], sample));
  }
  verdict.geometric_stiffness = geometric_stiffness(model, stretched);
  for (const std::string& note : notes_on(*verdict.geometric_stiffness)) result.text += fmt::format("note: {}\n", note);
  for (const Who who : kBothSolvers) verdict.trajectories[index(who)] = found[index(who)];
}

NumberRow number(std::string name, std::string unit, double one, double other, double scale, double need) {
  return {std::move(name), std::move(unit), {one, other}, matching_digits(one - other, scale), need};
}

namespace {

std::string values_text(const NumberRow& row) {
  if (std::isnan(row.values[0]) && std::isnan(row.values[1])) return "";
  return fmt::format("cartesian {:.10g}, relative {:.10g} {}, ", row.values[0], row.values[1], row.unit);
}

void note_numbers(AnalysisVerdict& result) {
  for (const NumberRow& row : result.numbers) {
    if (row.agrees()) continue;
    const std::string resolvable = row.resolvable ? " of " + format_digits(*row.resolvable) + " resolvable" : "";
    result.wrenches.findings.push_back({fmt::format("{}: {}{} digits{} (need {:g})", row.name, values_text(row),
                                                    format_digits(row.digits), resolvable, row.need),
                                        fmt::format("{}: the solvers find different ones", result.analysis)});
  }
}

}  // namespace

void require_judged(AnalysisVerdict& result) {
  const ComponentCount count = count_components(result.wrenches);
  const bool compares_anything =
      count.judged > 0 || has_judged_sums(result.wrenches) || result.wrenches.same_state.digits;
  if (count.total == 0 || compares_anything) return;
  result.wrenches.failures.emplace_back("no reaction was judged: none is unique, or none is resolved");
}

void require_unique(AnalysisVerdict& result) {
  const auto is_unique = [](const QuantityRow& row) {
    return row.unique && (row.quantity.kind == Kind::reaction || row.quantity.kind == Kind::element);
  };
  const Verdict& verdict = result.wrenches;
  if (std::any_of(verdict.rows.begin(), verdict.rows.end(), is_unique)) return;
  if (std::any_of(verdict.others.begin(), verdict.others.end(), is_unique)) return;
  require_judged(result);
}

void conclude(AnalysisVerdict& result) {
  note_numbers(result);
  Verdict& verdict = result.wrenches;
  if (result.numbers.empty() && !(has_judged(verdict) && carries_something(verdict))) {
    verdict.failures.emplace_back("nothing that was judged carries anything: agreement on nothing is no verdict");
  }
  conclude(verdict);
}

void require_arrived(const Equilibrium& found, std::string_view solver, AnalysisVerdict& result) {
  constexpr double kArrived = 1e-8;  // of the length, rad: a search ends with less
  if (found.step_left <= kArrived) return;
  result.wrenches.findings.push_back(
      {fmt::format("{}: the search for an equilibrium ended {:.1e} before it", solver, found.step_left),
       fmt::format("allowed {:.1e}: what it says is no rest", kArrived)});
}

std::string equilibrium_text(const Equilibrium& found, std::string_view solver) {
  std::string text =
      fmt::format("{}: equilibrium after {} steps, the last of {:.1e}", solver, found.iterations - 1, found.last_step);
  if (found.unstable > 0) text += fmt::format("; unstable in {} direction(s)", found.unstable);
  text += '\n';
  for (const FreeDirection& direction : found.free) {
    text += fmt::format("  without stiffness, as near to its start as balance lets it be: {}\n", direction.name);
  }
  return text;
}

}  // namespace concord::compare::analyses
