#include "compare/verdict/uniqueness.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "common/error.h"
#include "compare/audit/carried_components.h"

namespace concord::compare {

namespace {

Uniqueness from_flags(bool unique, bool decided) {
  if (!decided) return Uniqueness::undecided;
  return unique ? Uniqueness::unique : Uniqueness::not_unique;
}

/// The flag of one component in `flags`, or in what is decided of it.
bool flag_of(const JointUniqueness& flags, const Quantity& quantity, int component) {
  switch (quantity.kind) {
    case Kind::total:
      return flags.unique_total[index(quantity.side)][component];
    case Kind::driver:
      return flags.unique_tau[component];
    default:
      return flags.unique[index(quantity.side)][component];
  }
}

Uniqueness of_component(const RankReport& report, const Quantity& quantity, int component) {
  const auto joint = static_cast<std::size_t>(quantity.owner);
  const bool decided = report.decided.empty() || flag_of(report.decided.at(joint), quantity, component);
  return from_flags(flag_of(report.joints.at(joint), quantity, component), decided);
}

Uniqueness of_coupling(const RankReport& report, int coupling) {
  const auto k = static_cast<std::size_t>(coupling);
  const bool independent = report.rank == report.constraints;
  const bool unique = report.unique_coupling.empty() ? independent : report.unique_coupling.at(k);
  return from_flags(unique, report.decided_coupling.empty() || report.decided_coupling.at(k));
}

/// The worse of two: what is not unique is so whatever else is undecided.
Uniqueness worse(Uniqueness one, Uniqueness other) { return std::max(one, other); }

Uniqueness uniqueness_of(const RankReport& report, const Quantity& quantity) {
  switch (quantity.kind) {
    case Kind::reaction:
    case Kind::total:
    case Kind::driver:
      return of_component(report, quantity, quantity.component);
    case Kind::reaction_global: {
      const int first = quantity.component < 3 ? 0 : 3;
      Uniqueness all = Uniqueness::unique;
      for (int c = first; c < first + 3; ++c) all = worse(all, of_component(report, quantity, c));
      return all;
    }
    case Kind::coupling:
      return of_coupling(report, quantity.owner);
    default:
      return Uniqueness::unique;
  }
}

bool can_be_redundant(Kind kind) {
  return kind != Kind::element && kind != Kind::acceleration && kind != Kind::body_sum;
}

}  // namespace

bool can_carry(const Model& model, const Quantity& quantity) {
  const bool is_wrench = quantity.kind == Kind::reaction || quantity.kind == Kind::total;
  if (!is_wrench || carries(*model.joints[quantity.owner].type, quantity.side, quantity.component)) return true;
  return quantity.kind == Kind::total && !forced_speeds(model, quantity.owner).empty();
}

std::vector<Uniqueness> uniqueness_of(const QuantityLayout& layout, const RankReport& report) {
  std::vector<Uniqueness> all;
  all.reserve(layout.quantities().size());
  for (const Quantity& quantity : layout.quantities()) {
    all.push_back(uniqueness_of(report, quantity));
  }
  return all;
}

Eigen::Array<bool, Eigen::Dynamic, 1> unique_rows(const QuantityLayout& layout, const RankReport& report) {
  Eigen::Array<bool, Eigen::Dynamic, 1> unique(static_cast<Eigen::Index>(layout.quantities().size()));
  for (Eigen::Index row = 0; row < unique.size(); ++row) {
    const Quantity& quantity = layout.quantities()[static_cast<std::size_t>(row)];
    unique(row) = uniqueness_of(report, quantity) == Uniqueness::unique;
  }
  return unique;
}

RankReports report_ranks(const std::array<Solver*, 2>& solvers, std::vector<SharedState>& states, int& dropped,
                         std::string& why) {
  RankReports reports;
  std::vector<SharedState> kept;
  for (SharedState& shared : states) {
    try {
      std::array<RankReport, 2> both{solvers[0]->rank(shared.state), solvers[1]->rank(shared.state)};
      reports.push_back(std::move(both));
      kept.push_back(std::move(shared));
    } catch (const SolverError& error) {
      if (dropped++ == 0) why = error.what();
    }
  }
  states = std::move(kept);
  return reports;
}

namespace {

/// Whether a body that joints hold redundantly stands elsewhere in the other pose, by 1e-4 of the model's length, or is
/// turned by so much; any body where no joint does. What moves beside a locked loop says nothing of it.
bool are_apart(const Model& model, const RankReport& report, const State& one, const State& other) {
  constexpr double kElsewhere = 1e-4;
  const double away = kElsewhere * model.length_scale();
  std::set<int> bodies;
  for (std::size_t k = 0; k < report.joints.size(); ++k) {
    const auto& unique = report.joints[k].unique;
    const auto has_redundant = [](const auto& flags) {
      return !std::all_of(flags.begin(), flags.end(), std::identity());
    };
    if (!std::any_of(unique.begin(), unique.end(), has_redundant)) continue;
    for (const Attachment& side : model.joints[k].sides) bodies.insert(side.body);
  }
  for (int i = 1; bodies.empty() && i < static_cast<int>(one.bodies.size()); ++i) bodies.insert(bodies.end(), i);
  return std::any_of(bodies.begin(), bodies.end(), [&](int i) {
    const BodyState& here = one.bodies[static_cast<std::size_t>(i)];
    const BodyState& there = other.bodies[static_cast<std::size_t>(i)];
    return (here.r - there.r).norm() > away ||
           std::min((here.p - there.p).norm(), (here.p + there.p).norm()) > kElsewhere;
  });
}

/// Whether a rank does not count rows that a pose beside a singular one may have by the root of round-off, as far as
/// it is closed.
bool is_apart_from_singular(const RankReport& report) {
  constexpr double kBesideSingular = 1e-6;
  return report.smallest_kept > kBesideSingular;
}

/// The largest rank that one solver reports in a general pose, and whether there are general poses.
struct GeneralRank {
  int rank = 0;
  bool is_clear = false;
};

GeneralRank general_rank(const Model& model, const std::vector<SharedState>& states, const RankReports& reports,
                         std::size_t who) {
  int largest = 0;
  int clear = 0;
  bool moves = false;
  std::optional<std::size_t> first;
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const RankReport& report = reports[k][who];
    largest = std::max(largest, report.rank);
    if (!is_apart_from_singular(report)) continue;
    clear = std::max(clear, report.rank);
    if (!first) first = k;
    moves = moves || (k != *first && are_apart(model, report, states[*first].state, states[k].state));
  }
  // A machine that is locked in a singular pose is apart from it in no other.
  return {moves ? clear : largest, moves};
}

}  // namespace

std::array<int, 2> general_ranks(const Model& model, const std::vector<SharedState>& states,
                                 const RankReports& reports) {
  return {general_rank(model, states, reports, 0).rank, general_rank(model, states, reports, 1).rank};
}

int leave_out_beside_singular(const Model& model, std::vector<SharedState>& states, RankReports& reports) {
  const std::array general{general_rank(model, states, reports, 0), general_rank(model, states, reports, 1)};
  const auto is_beside_singular = [&](const std::array<RankReport, 2>& both) {
    return (general[0].is_clear && !is_apart_from_singular(both[0])) ||
           (general[1].is_clear && !is_apart_from_singular(both[1]));
  };
  std::size_t kept = 0;
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (states[k].row < 0 && is_beside_singular(reports[k])) continue;
    if (kept != k) {
      states[kept] = std::move(states[k]);
      reports[kept] = std::move(reports[k]);
    }
    ++kept;
  }
  const auto left_out = static_cast<int>(states.size() - kept);
  states.resize(kept);
  reports.resize(kept);
  return left_out;
}

std::vector<std::string> lower_ranks(const Model& model, const std::array<Solver*, 2>& solvers,
                                     const std::vector<SharedState>& states, const RankReports& reports) {
  const std::array<int, 2> general = general_ranks(model, states, reports);
  std::vector<std::string> lower(states.size());
  for (std::size_t k = 0; k < states.size(); ++k) {
    for (std::size_t who = 0; who < 2; ++who) {
      const int rank = reports[k][who].rank;
      if (rank >= general[who] || !lower[k].empty()) continue;
      lower[k] =
          fmt::format("{}: at t = {:.6g} s the pose is singular: the constraints have rank {} there, {} in other poses",
                      solvers[who]->name(), states[k].state.t, rank, general[who]);
    }
  }
  return lower;
}

Mask judged_states(const QuantityLayout& layout, const RankReports& reports) {
  Mask mask = Mask::Constant(static_cast<Eigen::Index>(layout.quantities().size()),
                             static_cast<Eigen::Index>(reports.size()), true);
  for (std::size_t state = 0; state < reports.size(); ++state) {
    auto judged = mask.col(static_cast<Eigen::Index>(state));
    for (const RankReport& report : reports[state]) judged = judged && unique_rows(layout, report);
  }
  return mask;
}

namespace {

/// How often the solvers say something different, and where first.
struct Disagreement {
  int states = 0;
  double t = 0.0;
  std::array<int, 2> counts{};
  Quantity quantity;
  bool unique_for_cartesian = false;
};

void take(Disagreement& found, double t) {
  if (found.states++ == 0) found.t = t;
}

std::string in_states(const Disagreement& found, std::size_t total) {
  return fmt::format("in {} of {} states, first at t = {:.6g} s", found.states, total, found.t);
}

/// Where two solvers say different things of uniqueness and of counts, over states.
class Disagreements {
 public:
  explicit Disagreements(const QuantityLayout& layout) : layout_(layout) {}

  void add(const RankReport& one, const RankReport& other, double t) {
    ++states_;
    if (one.undecided || other.undecided) return;
    add_counts({{{one.constraints - one.rank, other.constraints - other.rank},
                 {one.degrees_of_freedom, other.degrees_of_freedom}}},
               t);
    const std::vector<Uniqueness> of_one = uniqueness_of(layout_, one);
    const std::vector<Uniqueness> of_other = uniqueness_of(layout_, other);
    std::set<Owner> here;  // each counts once in a state
    for (std::size_t row = 0; row < of_one.size(); ++row) {
      const Quantity& quantity = layout_.quantities()[row];
      if (!can_be_redundant(quantity.kind) || quantity.kind == Kind::reaction_global) continue;
      if (of_one[row] == Uniqueness::undecided || of_other[row] == Uniqueness::undecided) continue;
      if (of_one[row] == of_other[row] || !can_carry(layout_.model(), quantity)) continue;
      const Owner owner(quantity.kind, quantity.owner, quantity.side);
      if (here.insert(owner).second) add_flag(owner, quantity, of_one[row] == Uniqueness::unique, t);
    }
  }

  [[nodiscard]] std::vector<Finding> findings() const {
    std::vector<Finding> findings;
    constexpr std::array kWhat{"redundant constraints", "degrees of freedom"};
    for (int what = 0; what < 2; ++what) {
      const Disagreement& found = counts_[what];
      if (found.states == 0) continue;
      findings.push_back({fmt::format("rank: cartesian finds {} {}, relative {}, {}", found.counts[0], kWhat[what],
                                      found.counts[1], in_states(found, states_)),
                          "the solvers do not see the same constraints"});
    }
    for (const auto& [owner, found] : flags_) {
      findings.push_back(
          {fmt::format("rank: {}, {} is {} for cartesian, {} for relative, {}",
                       describe_owner(layout_.model(), found.quantity), describe_component(found.quantity),
                       found.unique_for_cartesian ? "unique" : "not unique",
                       found.unique_for_cartesian ? "not unique" : "unique", in_states(found, states_)),
           "the solvers do not see the same redundancy"});
    }
    return findings;
  }

 private:
  using Owner = std::tuple<Kind, int, Side>;

  void add_counts(const std::array<std::array<int, 2>, 2>& pairs, double t) {
    for (int what = 0; what < 2; ++what) {
      if (pairs[what][0] == pairs[what][1]) continue;
      if (counts_[what].states == 0) counts_[what].counts = pairs[what];
      take(counts_[what], t);
    }
  }

  void add_flag(const Owner& owner, const Quantity& quantity, bool unique_for_cartesian, double t) {
    Disagreement& found = flags_[owner];
    if (found.states == 0) {
      found.quantity = quantity;
      found.unique_for_cartesian = unique_for_cartesian;
    }
    take(found, t);
  }

  const QuantityLayout& layout_;
  std::size_t states_ = 0;
  std::array<Disagreement, 2> counts_;
  std::map<Owner, Disagreement> flags_;
};

}  // namespace

std::vector<Finding> compare_uniqueness(const QuantityLayout& layout, const std::vector<SharedState>& states,
                                        const RankReports& reports) {
  Disagreements disagreements(layout);
  for (std::size_t k = 0; k < reports.size(); ++k) {
    disagreements.add(reports[k][0], reports[k][1], states[k].state.t);
  }
  return disagreements.findings();
}

Mask mask_of_run(const Mask& mask, const std::vector<SharedState>& states, int samples) {
  Mask of_run = Mask::Constant(mask.rows(), samples, true);
  std::vector<bool> is_known(static_cast<std::size_t>(samples), false);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const int row = states[k].row;
    if (row < 0 || row >= samples) continue;
    is_known[static_cast<std::size_t>(row)] = true;
    of_run.col(row) = of_run.col(row) && mask.col(static_cast<Eigen::Index>(k));
  }
  for (int row = 0; row < samples; ++row) {
    if (!is_known[static_cast<std::size_t>(row)]) of_run.col(row).setConstant(false);
  }
  return of_run;
}

}  // namespace concord::compare
