#include "compare/attribution/attribution.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <tuple>
#include <utility>

#include "compare/attribution/reports.h"
#include "compare/audit/digits.h"
#include "compare/audit/kept_start.h"

namespace concord::compare {

namespace {

/// So many digits worse than the other solver, a solver breaks a rule even where it reaches the rule's need.
constexpr double kClearlyWorse = 2.5;
constexpr std::array kNames{"cartesian", "relative", "both solvers, or the audit itself"};
constexpr int kBoth = 2;

/// A rule that is broken at one place.
struct Breach {
  int solver = 0;
  const AuditedPlace* place = nullptr;
  const AuditFinding* finding = nullptr;
};

std::string name_of_place(const Model& model, const AuditedPlace& place) {
  switch (place.kind) {
    case AuditedPlace::Kind::body:
      return "body " + model.bodies[place.number].name;
    case AuditedPlace::Kind::joint:
      return "joint " + model.joints[place.number].name;
    case AuditedPlace::Kind::element:
      return "force element " + model.elements[place.number].name;
    default:
      return "coupling " + model.couplings[place.number].name;
  }
}

/// Everywhere one rule is broken, the worst first.
std::vector<Breach> breaches_of(const Evidence& evidence, AuditRule rule) {
  std::vector<Breach> breaches;
  const std::size_t n = std::min(evidence.audits[0].places.size(), evidence.audits[1].places.size());
  for (std::size_t k = 0; k < n; ++k) {
    const std::array<const AuditedPlace*, 2> places{&evidence.audits[0].places[k], &evidence.audits[1].places[k]};
    const std::array<const AuditFinding*, 2> found{&places[0]->by(rule), &places[1]->by(rule)};
    const int worse = found[0]->digits <= found[1]->digits ? 0 : 1;
    if (found[worse]->row.empty()) continue;
    const bool may_be_small = evidence.answers_differ || !found[worse]->holds();
    const bool is_clear = may_be_small && found[worse]->digits + kClearlyWorse < found[1 - worse]->digits;
    const bool does_other_hold = found[1 - worse]->holds();
    if (!is_clear && found[worse]->holds()) continue;
    breaches.push_back({is_clear || does_other_hold ? worse : kBoth, places[worse], found[worse]});
  }
  std::stable_sort(breaches.begin(), breaches.end(),
                   [](const Breach& a, const Breach& b) { return a.finding->digits < b.finding->digits; });
  return breaches;
}

/// The first breach that is such, by the order of the rules, the worst of a rule first.
template <class Test>
std::optional<Breach> first_breach(const Evidence& evidence, std::initializer_list<AuditRule> rules,
                                   const Test& is_such) {
  for (const AuditRule rule : rules) {
    for (const Breach& breach : breaches_of(evidence, rule)) {
      if (is_such(breach)) return breach;
    }
  }
  return std::nullopt;
}

bool is_of_one(const Breach& breach) { return breach.solver != kBoth; }

std::vector<EvaluatedState> all_states(const Evidence& evidence) {
  std::vector<EvaluatedState> all = evidence.states;
  all.insert(all.end(), evidence.drawn.begin(), evidence.drawn.end());
  return all;
}

std::string words_of(const Breach& breach) {
  return fmt::format("breaks the audit's rule \"{}\" by {} ({} digits)", name_of(breach.finding->rule),
                     breach.finding->row, format_digits(breach.finding->digits));
}

Attribution at(const Evidence& evidence, const Breach& breach, Term term) {
  return {breach.solver, term, name_of_place(evidence.model, *breach.place), words_of(breach)};
}

/// A force element that does not follow its law: its wrench follows from the state alone, all else from it.
std::optional<Attribution> blame_element(const Evidence& evidence) {
  for (const Breach& breach : breaches_of(evidence, AuditRule::force_law)) {
    if (breach.place->kind == AuditedPlace::Kind::element) return at(evidence, breach, Term::applied);
  }
  return std::nullopt;
}

/// Modes that are not those of the beam that is stated: both solvers take them from there.
std::optional<Attribution> blame_modal_data(const Evidence& evidence) {
  const std::vector<Breach> breaches = breaches_of(evidence, AuditRule::modal_data);
  if (breaches.empty()) return std::nullopt;
  const std::string& row = breaches.front().finding->row;
  const Term term = row == "modal damping"     ? Term::damping
                    : row == "modal stiffness" ? Term::elastic
                    : row == "mass integrals"  ? Term::inertia
                                               : Term::point;
  return at(evidence, breaches.front(), term);
}

/// Springs, actuators and couplings on joints that do not follow theirs.
std::optional<Attribution> blame_joint_law(const Evidence& evidence) {
  const std::vector<Breach> breaches = breaches_of(evidence, AuditRule::force_law);
  if (breaches.empty()) return std::nullopt;
  return at(evidence, breaches.front(), Term::applied);
}

/// A joint whose bodies do not move as it permits. What is wrong in a velocity is wrong in its rate too; where
/// accelerations alone are wrong, the misfit grows with accelerations (Jacobian) or with speeds (bias).
std::optional<Attribution> blame_joint_motion(const Evidence& evidence) {
  if (const auto stated = breaches_of(evidence, AuditRule::derivatives); !stated.empty()) {
    return at(evidence, stated.front(), Term::jacobian);
  }
  const std::vector<Breach> breaches = breaches_of(evidence, AuditRule::kinematics);
  if (breaches.empty()) return std::nullopt;
  const auto is_of_rate = [](const Breach& breach) { return breach.finding->row.starts_with("acceleration"); };
  const auto of_pose = std::find_if_not(breaches.begin(), breaches.end(), is_of_rate);
  if (of_pose != breaches.end()) return at(evidence, *of_pose, Term::jacobian);
  const Breach& worst = breaches.front();
  const int solver = worst.solver == kBoth ? 0 : worst.solver;
  return at(evidence, worst, fit_joint_misfit(evidence.model, worst.place->number, all_states(evidence), solver));
}

/// A driver or a coupling that is not followed.
std::optional<Attribution> blame_driver(const Evidence& evidence) {
  const std::vector<Breach> breaches = breaches_of(evidence, AuditRule::driver_law);
  if (breaches.empty()) return std::nullopt;
  const bool is_rate = breaches[0].finding->row.find("acceleration") != std::string::npos;
  if (breaches[0].place->kind != AuditedPlace::Kind::coupling) return at(evidence, breaches[0], Term::driver);
  return at(evidence, breaches[0], is_rate ? Term::bias : Term::jacobian);
}

/// A body that is out of balance, and the term that would close its sum.
struct BodyFit {
  const Breach* breach = nullptr;
  TermFit fit;
};

/// The term that closes the sums of most bodies, where it does so best: what all bodies share is wrong in all of them.
const BodyFit* most_told(const std::vector<BodyFit>& fits) {
  const auto count = [&](Term term) {
    return std::count_if(fits.begin(), fits.end(), [&](const BodyFit& one) { return one.fit.term == term; });
  };
  const BodyFit* best = nullptr;
  for (const BodyFit& one : fits) {
    if (best == nullptr || std::pair(-count(one.fit.term), one.fit.unexplained) <
                               std::pair(-count(best->fit.term), best->fit.unexplained)) {
      best = &one;
    }
  }
  return best;
}

/// A body whose forces do not add up. `sharp`: only if some term closes the sum well.
std::optional<Attribution> blame_dynamics(const Evidence& evidence, bool sharp) {
  constexpr double kSharp = 1e-2;
  const std::vector<Breach> breaches = breaches_of(evidence, AuditRule::free_body);
  const Auditor auditor(evidence.model);
  const std::vector<EvaluatedState> states = all_states(evidence);
  std::vector<BodyFit> fits;
  std::vector<BodyFit> sharp_ones;
  for (const Breach& breach : breaches) {
    const int solver = breach.solver == kBoth ? 0 : breach.solver;
    const TermFit fit = fit_term(evidence.model, auditor, breach.place->number, states, solver);
    fits.push_back({&breach, fit});
    if (fit.unexplained <= kSharp) sharp_ones.push_back(fits.back());
  }
  const BodyFit* chosen = most_told(sharp_ones);
  if (chosen == nullptr && !sharp) chosen = most_told(fits);
  if (chosen == nullptr) return std::nullopt;
  Attribution found = at(evidence, *chosen->breach, chosen->fit.term);
  if (found.term != Term::unknown) {
    found.because += fmt::format("; a term of this kind{} explains all but {:.1e} of what {} leaves over",
                                 chosen->fit.whose.empty() ? "" : " with the wrench of " + chosen->fit.whose,
                                 chosen->fit.unexplained, found.where);
  }
  if (found.term == Term::reaction) found.where = chosen->fit.whose;
  return found;
}

/// What a rule on reports says is wrong: axes, the other side, a point, or the share that drivers and springs have.
/// Where both solvers share a slip in that share, it is in the joint's page.
Term term_of_report(const Breach& breach) {
  switch (breach.finding->rule) {
    case AuditRule::two_frames:
      return Term::frame;
    case AuditRule::both_sides:
      return breach.finding->row.starts_with("F_") ? Term::side : Term::point;
    default:
      return breach.solver == kBoth ? Term::jacobian : Term::subtraction;
  }
}

/// What each solver's own report contradicts: axes, or the other side.
std::optional<Attribution> blame_own_report(const Evidence& evidence) {
  const auto breach = first_breach(evidence, {AuditRule::two_frames, AuditRule::both_sides}, is_of_one);
  return breach ? std::optional(at(evidence, *breach, term_of_report(*breach))) : std::nullopt;
}

/// The solver whose reports break a rule, and how; both if neither is clearly worse.
std::pair<int, std::string> who_reports_wrongly(const Evidence& evidence) {
  const auto breach = first_breach(evidence,
                                   {AuditRule::two_frames, AuditRule::both_sides, AuditRule::drivers,
                                    AuditRule::workless, AuditRule::force_law, AuditRule::free_body},
                                   is_of_one);
  if (!breach) return {kBoth, ""};
  return {breach->solver, "; " + words_of(*breach)};
}

/// Bodies move alike and wrenches differ.
std::optional<Attribution> blame_report(const Evidence& evidence) {
  const std::vector<ReportFault> faults = find_report_faults(evidence.model, evidence.states, evidence.ambiguous);
  if (faults.empty()) return blame_own_report(evidence);
  const ReportFault* fault = &faults.front();
  if (fault->term == Term::point && breaches_of(evidence, AuditRule::both_sides).empty() &&
      breaches_of(evidence, AuditRule::two_frames).empty()) {
    // Where drivers prescribe all motion, what is wrong in a body's torques shows in reactions alone.
    std::optional<Attribution> of_body = blame_dynamics(evidence, false);
    if (of_body && of_body->term != Term::reaction && of_body->term != Term::unknown) return of_body;
  }
  if (fault->term != Term::subtraction && faults.back().term == Term::reaction) {
    // Wrenches that are found one from the other are wrong together: the body that is out of balance knows the first.
    std::optional<Attribution> of_body = blame_dynamics(evidence, true);
    if (of_body && of_body->term == Term::reaction) return of_body;
    if (auto own = blame_own_report(evidence)) return own;
    fault = &faults.back();
  }
  auto [solver, words] = who_reports_wrongly(evidence);
  return Attribution{solver, fault->term, "joint " + evidence.model.joints[fault->joint].name, fault->because + words};
}

/// Directions that a joint permits and in which it pushes all the same, for both solvers: its page contradicts itself.
std::optional<Attribution> blame_page(const Evidence& evidence) {
  const auto breach =
      first_breach(evidence, {AuditRule::workless}, [](const Breach& one) { return one.solver == kBoth; });
  return breach ? std::optional(at(evidence, *breach, term_of_report(*breach))) : std::nullopt;
}

/// A rule on reports that does not hold, where nothing else is told: other causes break these, too.
std::optional<Attribution> blame_broken_report(const Evidence& evidence) {
  const auto breach =
      first_breach(evidence, {AuditRule::two_frames, AuditRule::both_sides, AuditRule::drivers, AuditRule::workless},
                   [](const Breach& one) { return !one.finding->holds(); });
  return breach ? std::optional(at(evidence, *breach, term_of_report(*breach))) : std::nullopt;
}

/// Starts that are not where the model wants them, although states are answered alike.
std::optional<Attribution> blame_start(const Evidence& evidence) {
  constexpr double kSameStart = 1e-9;
  double largest = kSameStart;
  std::optional<Attribution> found;
  for (int solver = 0; solver < 2; ++solver) {
    if (evidence.starts[solver] == nullptr) return std::nullopt;
    const KeptStart start = audit_kept_start(evidence.model, *evidence.starts[solver]);
    if (start.off <= largest) continue;
    largest = start.off;
    found = Attribution{solver, Term::start, start.owner, start.text()};
  }
  return found;
}

Attribution from(const ConstraintFault& fault) { return {fault.solver, fault.term, fault.where, fault.because}; }

/// A rank that is wrong is none of what follows from it: rows that are left out let joints open, those that are counted
/// twice leave nothing determined.
std::optional<Attribution> blame_count(const Evidence& evidence) {
  const auto fault = ConstraintOpinion(evidence.model, evidence.constraints).wrong_count();
  return fault ? std::optional(from(*fault)) : std::nullopt;
}

/// Flags alone, where nothing else is wrong: they are found by the same ways as wrenches.
std::optional<Attribution> blame_uniqueness(const Evidence& evidence) {
  const auto fault = ConstraintOpinion(evidence.model, evidence.constraints).wrong_uniqueness();
  return fault ? std::optional(from(*fault)) : std::nullopt;
}

}  // namespace

std::vector<int> bodies_out_of_balance(const Evidence& evidence, int solver) {
  std::vector<int> bodies;
  for (const Breach& breach : breaches_of(evidence, AuditRule::free_body)) {
    if (breach.solver == solver) bodies.push_back(breach.place->number);
  }
  return bodies;
}

std::vector<int> elements_against_law(const Evidence& evidence, int solver) {
  std::vector<int> elements;
  for (const Breach& breach : breaches_of(evidence, AuditRule::force_law)) {
    const bool is_element = breach.place->kind == AuditedPlace::Kind::element;
    if (is_element && breach.solver == solver) elements.push_back(breach.place->number);
  }
  return elements;
}

namespace {

/// Up to so many guesses.
std::vector<Attribution> guess(const Evidence& evidence, std::size_t most) {
  using Rule = std::function<std::optional<Attribution>(const Evidence&)>;
  const Rule sharp = [](const Evidence& all) { return blame_dynamics(all, true); };
  const Rule blunt = [](const Evidence& all) { return blame_dynamics(all, false); };
  const bool alike = evidence.answers_differ && !evidence.states.empty() && move_alike(evidence.states);
  // From causes to what follows from them. Where the bodies move alike, it is the report that differs.
  const std::vector<Rule> where_alike{blame_count, blame_modal_data,   blame_element, blame_report,
                                      blame_page,  blame_joint_motion, blame_driver,  blame_joint_law,
                                      blunt,       blame_uniqueness,   blame_start};
  const std::vector<Rule> where_not{blame_count,        blame_modal_data, blame_element, sharp,
                                    blame_joint_motion, blame_driver,     blunt,         blame_joint_law,
                                    blame_uniqueness,   blame_start};
  std::vector<Attribution> causes;
  for (const Rule& rule : alike ? where_alike : where_not) {
    if (causes.size() == most) break;
    const auto found = rule(evidence);
    if (!found) continue;
    const auto is_same = [&](const Attribution& one) {
      return std::tie(one.solver, one.term, one.where) == std::tie(found->solver, found->term, found->where);
    };
    if (std::none_of(causes.begin(), causes.end(), is_same)) causes.push_back(*found);
  }
  if (causes.empty()) {
    if (const auto found = blame_broken_report(evidence)) causes.push_back(*found);
  }
  return causes;
}

}  // namespace

std::vector<Attribution> find_causes(const Evidence& evidence) {
  constexpr std::size_t kMost = 5;
  return guess(evidence, kMost);
}

std::optional<Attribution> find_cause(const Evidence& evidence) {
  const std::vector<Attribution> causes = guess(evidence, 1);
  return causes.empty() ? std::nullopt : std::optional(causes.front());
}

std::optional<Attribution> find_cause_of_stop(const Model& model, const std::vector<AskedState>& asked) {
  ConstraintOpinion opinion(model, asked);
  auto fault = opinion.wrongly_closed();
  if (!fault) fault = opinion.refuses_closed();
  if (!fault) fault = opinion.wrong_velocities();
  if (!fault) fault = opinion.wrong_count();
  if (!fault) fault = opinion.wrongly_singular();
  return fault ? std::optional(from(*fault)) : std::nullopt;
}

std::string describe(const Attribution& blame) {
  if (blame.term == Term::statement) return fmt::format("no solver, at {}: {}", blame.where, blame.because);
  return fmt::format("{}, at {}, in the term \"{}\": {}", kNames[blame.solver], blame.where, name_of(blame.term),
                     blame.because);
}

}  // namespace concord::compare
