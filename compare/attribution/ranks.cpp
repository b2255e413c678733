#include "compare/attribution/ranks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "compare/audit/carried_components.h"

namespace concord::compare {

namespace {

constexpr std::array kComponents{"F_x", "F_y", "F_z", "T_x", "T_y", "T_z"};

/// Owners that hold each other, the first few.
std::string names_of(const std::vector<std::string>& owners) {
  constexpr std::size_t kMost = 6;
  if (owners.empty()) return "the machine as a whole";
  const std::vector<std::string> first(owners.begin(),
                                       owners.begin() + static_cast<std::ptrdiff_t>(std::min(kMost, owners.size())));
  return fmt::format("{}{}", fmt::join(first, ", "), owners.size() > kMost ? ", ..." : "");
}

/// One flag as both solvers and the third opinion see it.
struct Flag {
  std::string what;
  std::array<bool, 2> said;
  bool is_unique;
};

/// Flags on which the solvers contradict each other while all are decided.
class Contradictions {
 public:
  Contradictions(const Model& model, const RankReport& one, const RankReport& other, const RankReport& third)
      : model_(model), reports_{&one, &other, &third} {
    const auto joints = model.joints.size();
    if (one.joints.size() != joints || other.joints.size() != joints) return;
    for (std::size_t k = 0; k < joints; ++k) add_joint(k);
    for (std::size_t g = 0; g < model.couplings.size(); ++g) {
      take("the force of coupling " + model.couplings[g].name, [g](const RankReport& report, bool decided) {
        const std::vector<bool>& flags = decided ? report.decided_coupling : report.unique_coupling;
        return flags.empty() || flags.at(g);
      });
    }
  }

  [[nodiscard]] const std::vector<Flag>& flags() const { return flags_; }

 private:
  void add_joint(std::size_t k) {
    const Joint& joint = model_.joints[k];
    const auto of = [k](const RankReport& report, bool decided) -> const JointUniqueness& {
      static const JointUniqueness kAll;
      return !decided ? report.joints.at(k) : report.decided.empty() ? kAll : report.decided.at(k);
    };
    for (const Side side : kSides) {
      const int s = index(side);
      const std::string on = fmt::format("joint {} on {}", joint.name, model_.bodies[joint.on(side).body].name);
      for (int c = 0; c < 6; ++c) {
        if (carries(*joint.type, side, c)) {
          take(fmt::format("{} of {}", kComponents[c], on),
               [=](const RankReport& report, bool decided) { return of(report, decided).unique[s][c]; });
        }
        take(fmt::format("{} of the total of {}", kComponents[c], on),
             [=](const RankReport& report, bool decided) { return of(report, decided).unique_total[s][c]; });
      }
    }
    for (int c = 0; c < joint.type->n_u(); ++c) {
      take(fmt::format("tau_{} of joint {}", c + 1, joint.name),
           [=](const RankReport& report, bool decided) { return of(report, decided).unique_tau[c]; });
      take(fmt::format("driver {} of joint {}", c + 1, joint.name),
           [=](const RankReport& report, bool decided) { return of(report, decided).unique_driver[c]; });
    }
  }

  template <class Reader>
  void take(std::string what, const Reader& read) {
    for (const RankReport* report : reports_) {
      if (!read(*report, true)) return;
    }
    const std::array<bool, 2> said{read(*reports_[0], false), read(*reports_[1], false)};
    if (said[0] != said[1]) flags_.push_back({std::move(what), said, read(*reports_[2], false)});
  }

  const Model& model_;
  std::array<const RankReport*, 3> reports_;
  std::vector<Flag> flags_;
};

}  // namespace

ConstraintOpinion::ConstraintOpinion(const Model& model, const std::vector<AskedState>& asked)
    : model_(model), asked_(asked), constraints_(asked.size()) {
  for (const AskedState& one : asked) left_open_.push_back(place_left_open(model, one.state));
}

const MachineConstraints& ConstraintOpinion::at(std::size_t state) {
  if (!constraints_[state]) constraints_[state].emplace(model_, asked_[state].state);
  return *constraints_[state];
}

bool ConstraintOpinion::is_sure(std::size_t state) { return left_open_[state].empty() && at(state).is_sure(); }

bool ConstraintOpinion::is_wrong(std::size_t state, int solver) {
  const auto& said = asked_[state].by[solver].rank;
  if (!said || said->undecided || !is_sure(state)) return false;
  const RankReport& third = at(state).report();
  return said->degrees_of_freedom != third.degrees_of_freedom ||
         (said->constraints == third.constraints && said->rank != third.rank);
}

std::optional<ConstraintFault> ConstraintOpinion::wrong_count_of(int solver) {
  int wrong = 0;
  std::size_t first = 0;
  for (std::size_t k = 0; k < asked_.size(); ++k) {
    if (is_wrong(k, 1 - solver)) return std::nullopt;
    if (is_wrong(k, solver) && wrong++ == 0) first = k;
  }
  if (wrong == 0) return std::nullopt;
  const RankReport& said = *asked_[first].by[solver].rank;
  const MachineConstraints& third = at(first);
  ConstraintFault fault{solver, Term::rank, names_of(third.in_self_stress()), ""};
  fault.because = fmt::format(
      "finds rank {} of {} constraints and {} degrees of freedom; the joints themselves give {} of {} and {} (by the "
      "comparator's own count, in {} of {} states, first at t = {:.4g} s)",
      said.rank, said.constraints, said.degrees_of_freedom, third.report().rank, third.report().constraints,
      third.report().degrees_of_freedom, wrong, asked_.size(), asked_[first].state.t);
  const MatX& tangent = asked_[first].by[solver].tangent;
  if (tangent.rows() == 0) return fault;
  const SpanOfVelocities span = third.hold_against(tangent);
  // Rows that were left out, or counted twice, permit more or less; wrong rows permit something else.
  if (!span.holds_all && !span.holds_nothing_else) {
    fault.term = Term::jacobian;
    fault.where = span.worst;
    fault.because += fmt::format("; the velocities that it permits are off by {:.1e} there", span.misfit);
  }
  return fault;
}

std::optional<ConstraintFault> ConstraintOpinion::wrong_count() {
  for (int solver = 0; solver < 2; ++solver) {
    if (auto fault = wrong_count_of(solver)) return fault;
  }
  return std::nullopt;
}

std::optional<ConstraintFault> ConstraintOpinion::wrong_velocities() {
  std::array<ConstraintFault, 2> faults;
  std::array<int, 2> wrong{};
  for (std::size_t k = 0; k < asked_.size(); ++k) {
    for (int solver = 0; solver < 2; ++solver) {
      const MatX& tangent = asked_[k].by[solver].tangent;
      if (tangent.rows() == 0 || !is_sure(k)) continue;
      const SpanOfVelocities span = at(k).hold_against(tangent);
      if (span.holds_all || span.holds_nothing_else || wrong[solver]++ > 0) continue;
      faults[solver] = {solver, Term::jacobian, span.worst,
                        fmt::format("permits velocities that are {:.1e} off what the joints permit, at t = {:.4g} s",
                                    span.misfit, asked_[k].state.t)};
    }
  }
  if ((wrong[0] > 0) == (wrong[1] > 0)) return std::nullopt;
  return faults[wrong[0] > 0 ? 0 : 1];
}

std::optional<ConstraintFault> ConstraintOpinion::wrongly_closed() {
  const auto fault = [](int solver, const std::string& open, double t) {
    return ConstraintFault{
        solver, Term::jacobian, open,
        fmt::format("leaves it open where it closes the machine by its own equations, at t = {:.4g} s", t)};
  };
  for (std::size_t k = 0; k < asked_.size(); ++k) {
    if (!left_open_[k].empty()) return fault(asked_[k].owner, left_open_[k], asked_[k].state.t);
    for (int solver = 0; solver < 2; ++solver) {
      const auto& closed = asked_[k].by[solver].closed;
      if (!closed) continue;
      const std::string open = place_left_open(model_, *closed);
      if (!open.empty()) return fault(solver, open, closed->t);
    }
  }
  return std::nullopt;
}

std::optional<ConstraintFault> ConstraintOpinion::refuses_closed() const {
  using Answer = StatedConstraints::Answer;
  for (int solver = 0; solver < 2; ++solver) {
    std::vector<std::size_t> refused;
    for (std::size_t k = 0; k < asked_.size(); ++k) {
      const auto& by = asked_[k].by;
      if (!left_open_[k].empty() || by[1 - solver].answer != Answer::given) continue;
      if (by[solver].answer == Answer::open) refused.push_back(k);
    }
    if (2 * refused.size() <= asked_.size()) continue;
    const StatedConstraints& first = asked_[refused.front()].by[solver];
    std::string place = first.place;
    std::erase(place, '\'');
    return ConstraintFault{solver, Term::jacobian, place,
                           fmt::format("calls {} of {} states open that the joints themselves call closed: {}",
                                       refused.size(), asked_.size(), first.words)};
  }
  return std::nullopt;
}

int ConstraintOpinion::general_rank() {
  int rank = 0;
  for (std::size_t k = 0; k < asked_.size(); ++k) rank = std::max(rank, at(k).report().rank);
  return rank;
}

bool ConstraintOpinion::is_clearly_regular(std::size_t state) {
  constexpr double kClear = 1e-4;
  const RankReport& third = at(state).report();
  return is_sure(state) && third.rank == general_rank() && third.smallest_kept > kClear;
}

std::optional<ConstraintFault> ConstraintOpinion::wrongly_singular() {
  using Answer = StatedConstraints::Answer;
  for (int solver = 0; solver < 2; ++solver) {
    std::size_t wrong = 0;
    std::size_t first = 0;
    for (std::size_t k = 0; k < asked_.size(); ++k) {
      const auto& by = asked_[k].by;
      if (by[solver].answer != Answer::singular || by[1 - solver].answer != Answer::given) continue;
      if (is_clearly_regular(k) && wrong++ == 0) first = k;
    }
    if (2 * wrong <= asked_.size()) continue;
    const RankReport& third = at(first).report();
    return ConstraintFault{
        solver, Term::rank, names_of(at(first).in_self_stress()),
        fmt::format("calls {} of {} poses singular in which {} of {} constraints are independent as "
                    "everywhere, by the comparator's own count: {}",
                    wrong, asked_.size(), third.rank, third.constraints, asked_[first].by[solver].words)};
  }
  return std::nullopt;
}

std::optional<ConstraintFault> ConstraintOpinion::wrong_uniqueness() {
  constexpr int kClearly = 10;
  std::array<int, 2> wrong{};
  std::array<ConstraintFault, 2> faults;
  for (std::size_t k = 0; k < asked_.size(); ++k) {
    const auto& by = asked_[k].by;
    if (!by[0].rank || !by[1].rank || !is_sure(k)) continue;
    const Contradictions all(model_, *by[0].rank, *by[1].rank, at(k).report());
    for (const Flag& flag : all.flags()) {
      const int solver = flag.said[0] == flag.is_unique ? 1 : 0;
      if (wrong[solver]++ > 0) continue;
      faults[solver] = {solver, Term::rank, names_of(at(k).in_self_stress()),
                        fmt::format("calls {} {}, which {} self-stress of the joints moves (by the comparator's own "
                                    "count, at t = {:.4g} s)",
                                    flag.what, flag.is_unique ? "not unique" : "unique", flag.is_unique ? "no" : "a",
                                    asked_[k].state.t)};
    }
  }
  for (int solver = 0; solver < 2; ++solver) {
    if (wrong[solver] == 0 || wrong[solver] < kClearly * wrong[1 - solver]) continue;
    faults[solver].because += fmt::format("; {} such flags in {} states", wrong[solver], asked_.size());
    return faults[solver];
  }
  return std::nullopt;
}

}  // namespace concord::compare
