#include "compare/resolution/uniqueness.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

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
    case Kind::tau:
      return flags.unique_tau[component];
    case Kind::share:
      return quantity.actor != Actor::driver || flags.unique_driver[component];
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
    case Kind::tau:
    case Kind::share:
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

Eigen::Array<bool, Eigen::Dynamic, 1> open_rows(const QuantityLayout& layout, const RankReport& report) {
  Eigen::Array<bool, Eigen::Dynamic, 1> open(static_cast<Eigen::Index>(layout.quantities().size()));
  for (Eigen::Index row = 0; row < open.size(); ++row) {
    const Quantity& quantity = layout.quantities()[static_cast<std::size_t>(row)];
    open(row) = uniqueness_of(report, quantity) == Uniqueness::not_unique;
  }
  return open;
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

void leave_out_isolated(Mask& unique, const Mask& open, const std::vector<Eigen::Index>& samples) {
  for (Eigen::Index row = 0; row < unique.rows(); ++row) {
    const auto counted = [&](const Mask& mask) {
      return std::count_if(samples.begin(), samples.end(), [&](Eigen::Index sample) { return mask(row, sample); });
    };
    if (counted(open) > counted(unique)) unique.row(row).setConstant(false);
  }
}

void leave_out_isolated(const QuantityLayout& layout, const std::vector<SharedState>& states,
                        const RankReports& reports, Mask& unique) {
  std::vector<Eigen::Index> of_run;
  Mask open = Mask::Constant(unique.rows(), unique.cols(), false);
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (states[k].row < 0) continue;
    of_run.push_back(static_cast<Eigen::Index>(k));
    for (const RankReport& report : reports[k])
      open.col(of_run.back()) = open.col(of_run.back()) || open_rows(layout, report);
  }
  leave_out_isolated(unique, open, of_run);
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
