#include "compare/quantities/third_opinion.h"

#include <cmath>
#include <limits>

#include "compare/quantities/align.h"
#include "compare/quantities/needs.h"

namespace concord::compare {

namespace {

/// The third opinion is nearer to one solver by so many digits than the solvers are to each other, and so has a vote.
constexpr double kVote = 0.7;

/// What three programs say in the states in which all answered: `pairs` are cartesian and third, relative and third,
/// both solvers.
struct Answers {
  std::array<std::vector<SharedState>, 3> pairs;
  std::vector<Eigen::Index> columns;  // of the budget
};

Answers ask(ThirdOpinion& third, const std::vector<SharedState>& states, ThirdReport& report) {
  Answers answers;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const SharedState& one = states[k];
    try {
      const Evaluation found = third.evaluate(one.state);
      answers.pairs[0].push_back({one.state, {one.evaluations[0], found}, one.row});
      answers.pairs[1].push_back({one.state, {one.evaluations[1], found}, one.row});
      answers.pairs[2].push_back(one);
      answers.columns.push_back(static_cast<Eigen::Index>(k));
    } catch (const SolverError& error) {
      if (report.failed++ == 0) report.first_failure = error.what();
    }
  }
  report.states = static_cast<int>(answers.columns.size());
  return answers;
}

/// What double precision resolves in another program, whose round-off nobody measures: no less than in the solvers, and
/// no less than the last bit of the machine's largest of the kind, because it may add up other terms than they do.
MatX with_machine(MatX resolution, const std::vector<Measured>& measured) {
  for (std::size_t k = 0; k < measured.size(); ++k) {
    const double bit = std::numeric_limits<double>::epsilon() * measured[k].machine;
    auto row = resolution.row(static_cast<Eigen::Index>(k));
    row = row.unaryExpr([bit](double known) { return std::fmax(known, bit); }).eval();
  }
  return resolution;
}

Accord accord_of(const Measured& measured) { return {measured.digits, measured.unexplained_digits}; }

}  // namespace

Blame blame_in(const ThirdRow& row) {
  const auto shares = [&](int who) { return row.shared[who].unexplained >= row.need; };
  if (row.between.unexplained >= row.solvers_need) return shares(0) && shares(1) ? Blame::nobody : Blame::third;
  const auto has_vote = [&](int who) { return row.shared[who].digits >= row.between.digits + kVote; };
  if (has_vote(0) == has_vote(1)) return Blame::unclear;
  return has_vote(0) ? Blame::relative : Blame::cartesian;
}

std::optional<double> ThirdReport::digits(Kind kind) const {
  std::optional<double> worst;
  for (const ThirdRow& row : rows) {
    if (row.quantity.kind == kind) worst = std::min(worst.value_or(kMostDigits), row.digits());
  }
  return worst;
}

ThirdReport ask_third(const QuantityLayout& layout, ThirdOpinion& third, const std::vector<SharedState>& states,
                      const Budget& budget) {
  ThirdReport report;
  report.name = third.name();
  const Answers answers = ask(third, states, report);
  if (answers.columns.empty()) return report;
  const Mask mask = (*budget.judged)(Eigen::all, answers.columns);
  const MatX resolution = (*budget.resolution)(Eigen::all, answers.columns);
  std::array<Series, 3> series;
  std::array<std::vector<Measured>, 3> measured;
  series[2] = align(layout, answers.pairs[2]);
  measured[2] = measure(layout, series[2], {&resolution, &mask});
  const MatX coarser = with_machine(resolution, measured[2]);
  for (std::size_t pair = 0; pair < 2; ++pair) {
    series[pair] = align(layout, answers.pairs[pair]);
    measured[pair] = measure(layout, series[pair], {&coarser, &mask});
  }
  for (std::size_t k = 0; k < layout.quantities().size(); ++k) {
    const Quantity& quantity = layout.quantities()[k];
    const bool is_told = quantity.kind != Kind::element && quantity.kind != Kind::share;
    if (!is_told || measured[2][k].samples == 0) continue;
    ThirdRow row;
    row.quantity = quantity;
    row.scale = measured[2][k].scale;
    row.solvers_need = needs_of(layout.model(), quantity).same_state;
    row.need = std::min(kThirdNeed, row.solvers_need);
    row.shared = {accord_of(measured[0][k]), accord_of(measured[1][k])};
    row.between = accord_of(measured[2][k]);
    const Measured& worst = measured[0][k].difference > measured[1][k].difference ? measured[0][k] : measured[1][k];
    row.t = worst.t;
    const auto at = [&](int pair, int who) {
      return series[pair].values[who](static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(worst.worst));
    };
    row.values = {at(2, 0), at(2, 1), at(0, 1)};
    report.rows.push_back(row);
  }
  return report;
}

}  // namespace concord::compare
