#include "compare/attribution/attribution.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/attribution/reports.h"
#include "compare/audit/digits.h"

namespace concord::compare {

namespace {

/// So many digits worse than the other solver, a solver breaks a rule even where it reaches the rule's need.
constexpr double kClearlyWorse = 2.5;
constexpr std::array kNames{"cartesian", "relative", "both solvers"};
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
    const bool is_clear = found[worse]->digits + kClearlyWorse < found[1 - worse]->digits;
    if (is_clear) {
      breaches.push_back({worse, places[worse], found[worse]});
    } else if (!found[worse]->holds()) {
      breaches.push_back({kBoth, places[worse], found[worse]});
    }
  }
  std::stable_sort(breaches.begin(), breaches.end(),
                   [](const Breach& a, const Breach& b) { return a.finding->digits < b.finding->digits; });
  return breaches;
}

std::string words_of(const Breach& breach) {
  return fmt::format("{} {} ({} digits)", kNames[breach.solver], breach_of(breach.finding->rule),
                     format_digits(breach.finding->digits));
}

/// Force elements and springs on joints that do not follow their laws.
std::optional<Attribution> blame_law(const Evidence& evidence) {
  const std::vector<Breach> breaches = breaches_of(evidence, AuditRule::force_law);
  const auto on_element = std::find_if(breaches.begin(), breaches.end(), [](const Breach& breach) {
    return breach.place->kind == AuditedPlace::Kind::element;
  });
  const auto chosen = on_element != breaches.end() ? on_element : breaches.begin();
  if (chosen == breaches.end()) return std::nullopt;
  return Attribution{chosen->solver, Term::applied, name_of_place(evidence.model, *chosen->place), words_of(*chosen)};
}

/// Places and velocities of bodies that a joint does not permit, drivers that are not followed, and then accelerations:
/// what is wrong in a velocity is wrong in its rate too.
std::optional<Attribution> blame_motion(const Evidence& evidence) {
  if (const auto stated = breaches_of(evidence, AuditRule::derivatives); !stated.empty()) {
    return Attribution{stated[0].solver, Term::jacobian, name_of_place(evidence.model, *stated[0].place),
                       words_of(stated[0])};
  }
  const std::vector<Breach> breaches = breaches_of(evidence, AuditRule::kinematics);
  const auto is_of_rate = [](const Breach& breach) { return breach.finding->row.starts_with("acceleration"); };
  const auto of_pose = std::find_if_not(breaches.begin(), breaches.end(), is_of_rate);
  const auto chosen = of_pose != breaches.end() ? of_pose : breaches.begin();
  if (chosen != breaches.end()) {
    const Term term = is_of_rate(*chosen) ? Term::bias : Term::jacobian;
    return Attribution{chosen->solver, term, name_of_place(evidence.model, *chosen->place),
                       words_of(*chosen) + ": " + chosen->finding->row};
  }
  const std::vector<Breach> driven = breaches_of(evidence, AuditRule::driver_law);
  if (driven.empty()) return std::nullopt;
  const bool is_coupling = driven[0].place->kind == AuditedPlace::Kind::coupling;
  const bool is_rate = driven[0].finding->row.find("acceleration") != std::string::npos;
  const Term term = !is_coupling ? Term::driver : is_rate ? Term::bias : Term::jacobian;
  return Attribution{driven[0].solver, term, name_of_place(evidence.model, *driven[0].place),
                     words_of(driven[0]) + ": " + driven[0].finding->row};
}

/// A body whose forces do not add up: the term that does, or would, close the sum.
std::optional<Attribution> blame_dynamics(const Evidence& evidence) {
  const std::vector<Breach> breaches = breaches_of(evidence, AuditRule::free_body);
  if (breaches.empty()) return std::nullopt;
  const Auditor auditor(evidence.model);
  std::optional<Attribution> first;
  double least = 1.0;
  for (const Breach& breach : breaches) {
    const int solver = breach.solver == kBoth ? 0 : breach.solver;
    const TermFit fit = fit_term(evidence.model, auditor, breach.place->number, evidence.states, solver);
    if (first && fit.unexplained >= least) continue;
    least = fit.unexplained;
    std::string where = name_of_place(evidence.model, *breach.place);
    std::string because = words_of(breach);
    if (fit.term != Term::unknown) {
      because += fmt::format("; a term of this kind{} explains all but {:.1e} of what {} leaves over",
                             fit.whose.empty() ? "" : " with the wrench of " + fit.whose, fit.unexplained, where);
    }
    if (fit.term == Term::reaction) where = fit.whose;
    first = Attribution{breach.solver, fit.term, std::move(where), std::move(because)};
  }
  return first;
}

/// Bodies move alike and wrenches differ.
std::optional<Attribution> blame_report(const Evidence& evidence) {
  std::optional<Breach> worst;
  for (const AuditRule rule : {AuditRule::two_frames, AuditRule::both_sides, AuditRule::drivers, AuditRule::workless,
                               AuditRule::force_law, AuditRule::free_body}) {
    const std::vector<Breach> breaches = breaches_of(evidence, rule);
    if (!breaches.empty() && !worst) worst = breaches.front();
  }
  const std::optional<ReportFault> fault = find_report_fault(evidence.model, evidence.states);
  if (!fault) return std::nullopt;
  const int solver = worst ? worst->solver : kBoth;
  std::string where = "joint " + evidence.model.joints[fault->joint].name;
  std::string because = fault->because;
  if (worst) because += "; " + words_of(*worst);
  return Attribution{solver, fault->term, std::move(where), std::move(because)};
}

/// Starts that differ although states are answered alike.
std::optional<Attribution> blame_start(const Evidence& evidence) {
  if (evidence.starts[0] == nullptr || evidence.starts[1] == nullptr) return std::nullopt;
  constexpr double kSameStart = 1e-9;
  double largest = kSameStart;
  std::optional<Attribution> found;
  for (std::size_t k = 0; k < evidence.model.joints.size(); ++k) {
    for (const auto part : {&State::q, &State::u}) {
      const auto& one = evidence.starts[0]->*part;
      const auto& other = evidence.starts[1]->*part;
      if (k >= one.size() || k >= other.size() || one[k].size() != other[k].size()) continue;
      const double size = std::max({1.0, one[k].norm(), other[k].norm()});
      const double apart = (one[k] - other[k]).norm() / size;
      if (apart <= largest) continue;
      largest = apart;
      found = Attribution{kBoth, Term::start, "joint " + evidence.model.joints[k].name,
                          fmt::format("the starts differ by {:.1e} in the joint's {}", apart,
                                      part == &State::q ? "coordinates" : "speeds")};
    }
  }
  return found;
}

}  // namespace

std::optional<Attribution> find_cause(const Evidence& evidence) {
  const bool alike = !evidence.states.empty() && move_alike(evidence.states);
  if (!alike) {
    if (auto law = blame_law(evidence)) return law;
    if (auto motion = blame_motion(evidence)) return motion;
    if (auto dynamics = blame_dynamics(evidence)) return dynamics;
    return blame_start(evidence);
  }
  if (auto report = blame_report(evidence)) return report;
  if (auto law = blame_law(evidence)) return law;
  if (auto motion = blame_motion(evidence)) return motion;
  if (auto dynamics = blame_dynamics(evidence)) return dynamics;
  return blame_start(evidence);
}

std::string describe(const Attribution& blame) {
  return fmt::format("{}: {}, term {}: {}", kNames[blame.solver], blame.where, name_of(blame.term), blame.because);
}

}  // namespace concord::compare
