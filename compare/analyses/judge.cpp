#include "compare/analyses/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "compare/analyses/kinematics.h"
#include "compare/analyses/statics.h"
#include "compare/audit/balance.h"
#include "compare/audit/digits.h"
#include "compare/audit/joint_motion.h"
#include "compare/report/info.h"
#include "compare/report/table.h"
#include "compare/verdict/agreement.h"
#include "compare/verdict/branch.h"
#include "compare/verdict/chart.h"
#include "compare/verdict/findings.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/states.h"
#include "compare/verdict/weighed_states.h"

namespace concord::compare::analyses {

namespace {

using Lines = std::vector<std::vector<std::string>>;

constexpr std::array kWho{Who::cartesian, Who::relative};

/// Both solvers on one branch, which is told in the result if the guesses left it open.
Solvers make_solvers(Model& model, const SolverMakers& makers, AnalysisVerdict& result) {
  std::string note;
  Solvers solvers = make_solvers_on_one_branch(model, makers, note);
  if (!note.empty()) result.text += "note: " + note + '\n';
  return solvers;
}

/// A body that deflects less, of the machine's length, is compared with this: it may be straight but for round-off.
constexpr double kLeastDeflection = 1e-6;

double own_need(const Model& model) { return model.is_flexible() ? kOwnFlexible : kOwnRigid; }

/// Judges the wrenches of what both solvers found: on the way of each, and in the same states. What they found stands
/// in the verdict's trajectories.
class Judge {
 public:
  Judge(const Model& model, const Solvers& solvers, AnalysisVerdict& result)
      : model_(model), layout_(model), solvers_(solvers), result_(result), verdict_(result.wrenches) {}

  /// `at_rest`: accelerations vanish and have no scale.
  void judge_wrenches(const std::array<Trajectory, 2>& found, bool at_rest) {
    describe(found);
    make_rows(layout_, verdict_);
    if (at_rest) {
      std::erase_if(verdict_.others, [](const QuantityRow& row) { return row.quantity.kind == Kind::acceleration; });
    }
    for (auto* rows : {&verdict_.rows, &verdict_.others}) {
      for (QuantityRow& row : *rows) row.need.same_run = result_.own_need;
    }
    judge_same_states(found);
    const std::array<const Trajectory*, 2> both{&found[0], &found[1]};
    const auto samples = static_cast<int>(found[0].samples.size());
    const WeighedRun own = weigh_run(weighed_, samples);
    judge_series(align(layout_, both, samples), Rung::same_run, own.budget());
    verdict_.motion = compare_motions(model_, both);
    audit(found);
    judge_rows();
    for (const Who who : kWho) verdict_.trajectories[index(who)] = found[index(who)];
  }

 private:
  void describe(const std::array<Trajectory, 2>& found) {
    verdict_.name = model_.name;
    verdict_.bodies = static_cast<int>(model_.bodies.size()) - 1;
    verdict_.joints = static_cast<int>(model_.joints.size());
    verdict_.need = default_needs(model_);
    result_.own_need = own_need(model_);
    for (const Who who : kWho) {
      SolverSummary& summary = verdict_.solvers[index(who)];
      summary.name = solvers_[index(who)]->name();
      summary.rank = solvers_[index(who)]->rank(found[index(who)].samples.front().state);
    }
  }

  void judge_same_states(const std::array<Trajectory, 2>& found) {
    const SharedStates shared = share({solvers_[0].get(), solvers_[1].get()}, run_states({&found[0], &found[1]}));
    verdict_.failures.insert(verdict_.failures.end(), shared.failures.begin(), shared.failures.end());
    for (const RefusedState& refused : shared.refusals) {
      verdict_.findings.push_back({refused.why, "same state: the closures differ"});
    }
    for (const std::string& pose : shared.singular) verdict_.failures.push_back(pose);
    weighed_ = weigh(layout_, {solvers_[0].get(), solvers_[1].get()}, shared.states, kSeed);
    if (!weighed_.dropped.empty()) verdict_.failures.push_back(weighed_.dropped);
    verdict_.rank_agrees = weighed_.findings.empty() && !weighed_.reports.empty();
    verdict_.findings.insert(verdict_.findings.end(), weighed_.findings.begin(), weighed_.findings.end());
    verdict_.same_state.samples = static_cast<int>(weighed_.states.size());
    for (const std::string& why : weighed_.singular) {
      if (!why.empty()) verdict_.failures.push_back(why);
    }
    if (!weighed_.states.empty()) judge_series(weighed_.series, Rung::same_state, weighed_.budget());
  }

  void judge_series(const Series& series, Rung rung, const Budget& budget) {
    const std::vector<Measured> measured = measure(layout_, series, budget);
    record(layout_, measured, rung, verdict_);
    std::vector<Finding> found = find_differences(layout_, series, measured, verdict_, rung, known_);
    std::move(found.begin(), found.end(), std::back_inserter(verdict_.findings));
  }

  void audit(const std::array<Trajectory, 2>& found) {
    for (const Who who : kWho) {
      Auditor auditor(model_);
      for (const Sample& sample : found[index(who)].samples) auditor.add(sample.state, sample.evaluation);
      const AuditReport report = auditor.report();
      SolverSummary& summary = verdict_.solvers[index(who)];
      summary.audit_digits = report.digits();
      summary.audit_worst = report.worst.text();
      verdict_.audit.digits = std::min(verdict_.audit.digits.value_or(kMostDigits), report.digits());
      summary.audit_need = need_of(report.worst.rule);
      if (report.holds()) continue;
      verdict_.findings.push_back({fmt::format("{} {}: {} (need {:g})", summary.name, breach_of(report.worst.rule),
                                               summary.audit_worst, summary.audit_need),
                                   "audit: from motions, wrenches, force laws and mass points alone"});
    }
    verdict_.audit.climbed = std::all_of(
        verdict_.solvers.begin(), verdict_.solvers.end(),
        [](const SolverSummary& solver) { return solver.audit_digits && *solver.audit_digits >= solver.audit_need; });
  }

  void judge_rows() {
    for (auto* rows : {&verdict_.rows, &verdict_.others}) {
      for (QuantityRow& row : *rows) judge_row(row);
    }
    verdict_.total = verdict_.judged = 0;
    for (const auto* rows : {&verdict_.rows, &verdict_.others}) {
      for (const QuantityRow& row : *rows) count(row);
    }
  }

  /// Components that joints can carry and those of force elements.
  void count(const QuantityRow& row) {
    if (row.quantity.kind != Kind::reaction && row.quantity.kind != Kind::element) return;
    ++verdict_.total;
    if (is_judged(row)) ++verdict_.judged;
  }

  void judge_row(QuantityRow& row) {
    if (!is_judged(row)) return;
    row.judgement = Judgement::agree;
    for (const Rung rung : {Rung::same_state, Rung::same_run}) {
      if (!judges(rung, row.quantity.kind)) continue;
      const auto digits = digits_of(row, rung);
      if (!meets_need(row, rung)) row.judgement = digits ? Judgement::differ : Judgement::not_judged;
      RungSummary& summary = rung == Rung::same_state ? verdict_.same_state : verdict_.same_run;
      const bool counts = row.quantity.kind == Kind::reaction || row.quantity.kind == Kind::element;
      if (digits && counts) summary.digits = std::min(summary.digits.value_or(kMostDigits), *digits);
    }
  }

  const Model& model_;
  QuantityLayout layout_;
  const Solvers& solvers_;
  AnalysisVerdict& result_;
  Verdict& verdict_;
  WeighedStates weighed_;
  std::vector<Quantity> known_;
};

void note_numbers(AnalysisVerdict& result) {
  for (const NumberRow& row : result.numbers) {
    if (row.agrees()) continue;
    result.wrenches.findings.push_back(
        {fmt::format("{}: cartesian {:.10g}, relative {:.10g} {}, {} digits (need {:g})", row.name, row.values[0],
                     row.values[1], row.unit, format_digits(row.digits), row.need),
         fmt::format("{}: the solvers find different ones", result.analysis)});
  }
}

void conclude(AnalysisVerdict& result) {
  note_numbers(result);
  Verdict& verdict = result.wrenches;
  if (result.numbers.empty() && !(has_judged(verdict) && carries_something(verdict))) {
    verdict.failures.emplace_back("nothing that was judged carries anything: agreement on nothing is no verdict");
  }
  if (!verdict.failures.empty()) {
    verdict.outcome = Outcome::failed;
  } else {
    verdict.outcome = verdict.findings.empty() ? Outcome::agree : Outcome::differ;
  }
}

NumberRow number(std::string name, std::string unit, double one, double other, double scale, double need) {
  return {std::move(name), std::move(unit), {one, other}, matching_digits(one - other, scale), need};
}

/// Calls `use` with name, unit, scale and number of every joint coordinate (balls left out) and modal coordinate.
template <class Use>
void for_each_coordinate(const Model& model, const State& state, const Use& use) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const auto frame = [&](Side side) { return place(joint.on(side), state.bodies[joint.on(side).body]); };
    const JointMotion motion =
        read_motion(*joint.type, relative_motion(frame(Side::parent), frame(Side::child)), state.q[k]);
    const std::vector<std::string> names = speed_names(*joint.type);
    const std::vector<bool> turns = turning_speeds(*joint.type);
    for (std::size_t word = 0; word < joint.type->permits.size(); ++word) {
      if (std::holds_alternative<joints::Ball>(joint.type->permits[word])) continue;
      const int q = first_q(*joint.type, static_cast<int>(word));
      const int u = first_u(*joint.type, static_cast<int>(word));
      for (int c = 0; c < n_u(joint.type->permits[word]); ++c) {
        const bool turn = turns[static_cast<std::size_t>(u + c)];
        use(fmt::format("{} of {}", names[static_cast<std::size_t>(u + c)], joint.name), turn ? "rad" : "m",
            turn ? 1.0 : model.length_scale(), motion.q(q + c));
      }
    }
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const VecX& a = state.bodies[i].a;
    if (a.size() == 0) continue;
    const VecX least = kLeastDeflection * model.length_scale() * largest_deflections(model.bodies[i]).cwiseInverse();
    for (Eigen::Index mode = 0; mode < a.size(); ++mode) {
      use(fmt::format("a_{} of {}", mode + 1, model.bodies[i].name), "1",
          std::max(a.cwiseAbs().maxCoeff(), least(mode)), a(mode));
    }
  }
}

/// Coordinates of two states, judged; and their values at the start in the text's table.
std::string judge_coordinates(const Model& model, const State& start, const std::array<const State*, 2>& found,
                              AnalysisVerdict& result) {
  std::array<std::vector<double>, 3> values;
  const std::array<const State*, 3> states{&start, found[0], found[1]};
  for (std::size_t k = 0; k < states.size(); ++k) {
    for_each_coordinate(model, *states[k],
                        [&](const std::string&, const char*, double, double value) { values[k].push_back(value); });
  }
  Lines lines{{"coordinate", "start", "cartesian", "relative", "unit", "digits"}};
  std::size_t row = 0;
  for_each_coordinate(model, *found[0], [&](const std::string& name, const char* unit, double scale, double) {
    result.numbers.push_back(number(name, unit, values[1][row], values[2][row], scale, result.own_need));
    lines.push_back({name, fmt::format("{:.6g}", values[0][row]), fmt::format("{:.10g}", values[1][row]),
                     fmt::format("{:.10g}", values[2][row]), unit, format_digits(result.numbers.back().digits)});
    ++row;
  });
  return lines.size() > 1 ? format_table(lines, {false, true, true, true, false, true}) : "";
}

std::vector<std::string> wrench_cells(const std::string& name, const std::string& body, const Wrench& wrench) {
  std::vector<std::string> line{name, body};
  for (const double value : wrench.vector()) line.push_back(fmt::format("{:.6g}", value));
  return line;
}

/// Reactions on both sides and element wrenches on their ends, as one solver gives them.
std::string wrench_text(const Model& model, const Evaluation& evaluation) {
  Lines lines{{"joint or element", "on", "F_x [N]", "F_y", "F_z", "T_x [N m]", "T_y", "T_z"}};
  for (const Side side : {Side::parent, Side::child}) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      lines.push_back(wrench_cells(model.joints[k].name, model.bodies[model.joints[k].on(side).body].name,
                                   evaluation.joints[k].reaction_on(side).in_C));
    }
    for (std::size_t k = 0; k < model.elements.size(); ++k) {
      const Attachment* end = end_of(model.elements[k], side);
      if (end == nullptr) continue;
      lines.push_back(wrench_cells(model.elements[k].name, model.bodies[end->body].name,
                                   evaluation.elements[k].on_side(side).in_C));
    }
  }
  std::stable_sort(lines.begin() + 1, lines.end(), [](const auto& a, const auto& b) { return a.front() < b.front(); });
  return "reactions and element wrenches by cartesian, in the frames of their sides:\n" +
         format_table(lines, {false, false, true, true, true, true, true, true});
}

Trajectory one_sample(const State& state, const Evaluation& evaluation) {
  Trajectory trajectory;
  trajectory.samples.push_back({state, evaluation, 0.0});
  return trajectory;
}

std::string equilibrium_text(const Equilibrium& found, std::string_view solver) {
  std::string text =
      fmt::format("{}: equilibrium after {} steps, the last of {:.1e}", solver, found.iterations - 1, found.last_step);
  if (found.unstable > 0) text += fmt::format("; unstable in {} direction(s)", found.unstable);
  text += '\n';
  for (const FreeDirection& direction : found.free) {
    text += fmt::format("  without stiffness, left where it started: {}\n", direction.name);
  }
  return text;
}

void compare_stiffness(const std::array<Equilibrium, 2>& found, AnalysisVerdict& result) {
  const auto size = [](const Equilibrium& one) { return static_cast<double>(one.free.size()); };
  result.numbers.push_back(
      number("directions without stiffness", "", size(found[0]), size(found[1]), 1.0, kMostDigits));
  result.numbers.push_back(number("unstable directions", "", found[0].unstable, found[1].unstable, 1.0, kMostDigits));
}

}  // namespace

AnalysisVerdict judge_statics(const Model& model, const SolverMakers& makers) {
  Model held = held_at_start(model);
  AnalysisVerdict result;
  result.analysis = "statics";
  const Solvers solvers = make_solvers(held, makers, result);
  const std::array<Equilibrium, 2> found{find_equilibrium(held, *solvers[0]), find_equilibrium(held, *solvers[1])};
  Judge(held, solvers, result)
      .judge_wrenches(
          {one_sample(found[0].state, found[0].evaluation), one_sample(found[1].state, found[1].evaluation)}, true);
  for (const Who who : kWho) {
    result.text += equilibrium_text(found[index(who)], solvers[index(who)]->name());
  }
  compare_stiffness(found, result);
  result.text += '\n' + judge_coordinates(held, solvers[0]->assemble(), {&found[0].state, &found[1].state}, result);
  result.text += '\n' + wrench_text(held, found[0].evaluation);
  conclude(result);
  return result;
}

Model as_it_starts(const Model& model, const SolverMakers& makers, std::string& note) {
  if (!model.run.from_equilibrium) return model;
  Model held = held_at_start(model);
  std::string branch;
  const Solvers solvers = make_solvers_on_one_branch(held, makers, branch);
  const std::array<Equilibrium, 2> found{find_equilibrium(held, *solvers[0]), find_equilibrium(held, *solvers[1])};
  const std::array<Trajectory, 2> states{one_sample(found[0].state, found[0].evaluation),
                                         one_sample(found[1].state, found[1].evaluation)};
  const MotionAgreement agreement = compare_motions(held, {&states[0], &states[1]});
  if (agreement.digits < own_need(model)) {
    throw SolverError(
        fmt::format("the run starts from the equilibrium, but {} differs: {} digits, need {:g}; see "
                    "`concord statics`",
                    agreement.worst, format_digits(agreement.digits), own_need(model)));
  }
  note = fmt::format("starts from the equilibrium, on which both agree to {} digits", format_digits(agreement.digits));
  if (!branch.empty()) note += "; " + branch;
  for (const FreeDirection& direction : found[0].free) {
    note += fmt::format("{} {}",
                        &direction == &found[0].free.front() ? "; without stiffness, left where they started:" : ",",
                        direction.name);
  }
  return started_at(model, found[0].state);
}

namespace {

/// How far two mode shapes point the same way: what of one is not along the other.
double shape_digits(const Mode& one, const Mode& other) {
  const std::complex<double> along = other.scaled_shape.dot(one.scaled_shape);
  return matching_digits((one.scaled_shape - along * other.scaled_shape).norm(), 1.0);
}

/// Whether no other eigenvalue is so near that the shapes of both mix; one below `least` is near to those of free
/// modes.
bool stands_alone(const std::vector<Mode>& modes, std::size_t k, double least) {
  const std::complex<double> own = modes[k].eigenvalue;
  if (modes[k].is_free || std::abs(own) < least) return false;
  for (std::size_t other = 0; other < modes.size(); ++other) {
    if (other != k && std::abs(own - modes[other].eigenvalue) < 1e-3 * std::abs(own)) return false;
  }
  return true;
}

/// Derivatives are good to 1e-12 of the largest, which moves an eigenvalue by that times its condition: it has the
/// eight digits that are needed only above this part of the fastest one times its condition; below, that is its scale.
constexpr double kResolved = 1e-4;

std::string eigenvalue_text(const Mode& mode) {
  return mode.oscillates() ? fmt::format("{:.8g} +- {:.10g}i", mode.eigenvalue.real(), mode.eigenvalue.imag())
                           : fmt::format("{:.10g}", mode.eigenvalue.real());
}

/// Judges one mode after the other, and makes the lines of the table.
class ModeJudge {
 public:
  ModeJudge(const Linearization& one, const Linearization& other, AnalysisVerdict& result)
      : one_(one), other_(other), result_(result) {
    for (const Mode& mode : one.modes) fastest_ = std::max(fastest_, std::abs(mode.eigenvalue));
  }

  void judge() {
    result_.numbers.push_back(count("number of modes", [](const Mode&) { return true; }));
    result_.numbers.push_back(count("number of free modes", [](const Mode& mode) { return mode.is_free; }));
    const ModePairs pairs = pair_modes(one_, other_);
    for (const auto& [k, partner] : pairs.both) judge_pair(k, partner);
    for (const std::size_t k : pairs.alone[0]) judge_alone("cartesian", one_.modes[k], {abs_of(one_.modes[k]), kNone});
    for (const std::size_t k : pairs.alone[1]) {
      judge_alone("relative", other_.modes[k], {kNone, abs_of(other_.modes[k])});
    }
    result_.text += '\n' + format_table(lines_, {true, true, true, true, true, true, false});
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  static double abs_of(const Mode& mode) { return std::abs(mode.eigenvalue); }

  template <class Counts>
  NumberRow count(const char* name, const Counts& counts) {
    const auto number_of = [&](const std::vector<Mode>& modes) {
      return static_cast<double>(std::count_if(modes.begin(), modes.end(), counts));
    };
    return number(name, "", number_of(one_.modes), number_of(other_.modes), 1.0, kMostDigits);
  }

  void judge_pair(std::size_t k, std::size_t partner) {
    const Mode& mode = one_.modes[k];
    const Mode& other = other_.modes[partner];
    const double condition = std::max(mode.condition, other.condition);
    const double scale = std::max({abs_of(mode), one_.resolution, kResolved * fastest_ * condition});
    const double digits = matching_digits(std::abs(mode.eigenvalue - other.eigenvalue), scale);
    NumberRow row{fmt::format("eigenvalue {}", k + 1), "1/s", {abs_of(mode), abs_of(other)}, digits, kEigenvalue};
    const bool alone = stands_alone(one_.modes, k, kResolved * fastest_);
    const double shape = shape_digits(mode, other);
    if (alone) row.digits = std::min(row.digits, shape);
    add_line(mode, format_digits(digits), alone ? format_digits(shape) : "-", "");
    result_.numbers.push_back(std::move(row));
  }

  void judge_alone(const char* solver, const Mode& mode, const std::array<double, 2>& values) {
    add_line(mode, format_digits(0.0), "-", fmt::format(" (found by {} alone)", solver));
    result_.numbers.push_back(
        {fmt::format("eigenvalue {} of {} alone", lines_.size() - 1, solver), "1/s", values, 0.0, kEigenvalue});
  }

  void add_line(const Mode& mode, std::string digits, std::string shape_digits, const std::string& remark) {
    lines_.push_back({fmt::format("{}", lines_.size()), fmt::format("{:.10g}", mode.frequency()),
                      fmt::format("{:.6g}", mode.damping_ratio()), eigenvalue_text(mode), std::move(digits),
                      std::move(shape_digits), (mode.is_free ? "free: " : "") + mode.motion + remark});
  }

  const Linearization& one_;
  const Linearization& other_;
  AnalysisVerdict& result_;
  double fastest_ = 0.0;
  Lines lines_{{"mode", "frequency [Hz]", "damping ratio", "eigenvalue [1/s]", "digits", "shape digits", "motion"}};
};

/// About a motion that is not steady, modes say how the machine behaves as if it stayed as it is now.
std::string steadiness_text(const Model& model, Solver& solver, const Linearization& found) {
  constexpr double kChanges = 1e-3;
  const Steadiness steadiness = steadiness_of(model, solver, found);
  if (steadiness.accelerates) {
    return "note: the machine accelerates in this state: modes are those of the machine frozen in it\n";
  }
  if (steadiness.change <= kChanges) return "";
  return fmt::format(
      "note: the motion is not steady: in a radian of it the matrices change by {:.2g} of the fastest rate; modes are "
      "those of the machine frozen in this state\n",
      steadiness.change);
}

}  // namespace

AnalysisVerdict judge_linearization(const Model& model, const SolverMakers& makers, bool at_equilibrium) {
  Model held = at_equilibrium ? held_at_start(model) : model;
  AnalysisVerdict result;
  result.analysis = "linearize";
  const Solvers solvers = make_solvers(held, makers, result);
  std::array<Trajectory, 2> states;
  for (const Who who : kWho) {
    Solver& solver = *solvers[index(who)];
    if (at_equilibrium) {
      const Equilibrium found = find_equilibrium(held, solver);
      result.text += equilibrium_text(found, solver.name());
      states[index(who)] = one_sample(found.state, found.evaluation);
    } else {
      const State start = solver.assemble();
      states[index(who)] = one_sample(start, solver.evaluate(start));
    }
    result.linearizations[index(who)] = linearize(held, solver, states[index(who)].samples[0].state);
  }
  Judge(held, solvers, result).judge_wrenches(states, at_equilibrium);
  result.text += steadiness_text(held, *solvers[0], *result.linearizations[0]);
  result.text += fmt::format("modes about the {}, by cartesian:\n", at_equilibrium ? "equilibrium" : "start");
  ModeJudge(*result.linearizations[0], *result.linearizations[1], result).judge();
  conclude(result);
  return result;
}

AnalysisVerdict judge_kinematics(const Model& asked, const SolverMakers& makers, const VerifyOptions& options) {
  Model model = asked;
  AnalysisVerdict result;
  result.analysis = "kinematics";
  const Solvers solvers = make_solvers(model, makers, result);
  const RunOptions run = run_options(model, options);
  result.wrenches.run = run;
  std::array<Trajectory, 2> found;
  for (const Who who : kWho) found[index(who)] = run_kinematics(model, *solvers[index(who)], run);
  Judge(model, solvers, result).judge_wrenches(found, false);
  result.text += fmt::format("{:g} s in {} steps; peak reactions by cartesian:\n{}", run.until, run.samples,
                             format_peaks(model, found[0]));
  conclude(result);
  return result;
}

namespace {

/// Accelerations of all bodies by the actuated machine, and the loads on them, against those of the driven one.
double round_trip_digits(const Model& model, const State& state, const Evaluation& there, const Evaluation& back) {
  const QuantityLayout layout(model);
  const Series series = align(layout, std::vector<SharedState>{{state, {there, back}}});
  const std::vector<Measured> measured = measure(layout, series);
  const VecX asked = scaled_accelerations(model, there);
  const VecX reached = scaled_accelerations(model, back);
  const double scale = std::max(asked.lpNorm<Eigen::Infinity>(), reference_acceleration(model, there));
  double worst = matching_digits((reached - asked).lpNorm<Eigen::Infinity>(), scale);
  for (std::size_t row = 0; row < measured.size(); ++row) {
    const Kind kind = layout.quantities()[row].kind;
    if (kind == Kind::body_sum || kind == Kind::element) worst = std::min(worst, measured[row].digits);
  }
  return worst;
}

}  // namespace

AnalysisVerdict judge_inverse(const Model& model, const SolverMakers& makers,
                              const std::vector<AskedAcceleration>& asked) {
  const std::vector<Prescribed> coordinates = prescribed_coordinates(model, asked);
  const State start = makers.cartesian(model)->assemble();
  Model driven = driven_through(model, start, coordinates);
  AnalysisVerdict result;
  result.analysis = "inverse";
  const Solvers solvers = make_solvers(driven, makers, result);
  std::array<Evaluation, 2> there;
  for (const Who who : kWho) there[index(who)] = solvers[index(who)]->evaluate(start);
  Judge(driven, solvers, result).judge_wrenches({one_sample(start, there[0]), one_sample(start, there[1])}, false);

  Lines lines{{"driven", "acceleration", "tau by cartesian", "by relative", "unit", "digits"}};
  for (const Prescribed& one : coordinates) {
    const auto tau = [&](Who who) { return there[index(who)].joints[one.joint].tau(one.speed(model)); };
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
  for (const Who who : kWho) {
    const Model actuated = actuated_by(model, there[index(who)], coordinates);
    for (const Who by : kWho) {
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
