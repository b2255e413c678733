#include "compare/invariance/invariance_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "common/error.h"
#include "compare/audit/digits.h"
#include "compare/invariance/moved_solver.h"
#include "compare/invariance/moves.h"
#include "compare/quantities/motions.h"
#include "compare/resolution/resolution.h"
#include "compare/resolution/term_sizes.h"
#include "compare/resolution/weighed_states.h"
#include "compare/states/branch.h"
#include "compare/states/singular_pose.h"
#include "compare/states/states.h"

namespace concord::compare::invariance {

bool is_nearer(const Measured& one, const Measured& other) {
  return std::pair(one.unexplained_digits, one.digits) < std::pair(other.unexplained_digits, other.digits);
}

std::optional<double> Nearest::resolvable() const {
  if (!(measured.resolution >= 0.0)) return std::nullopt;
  return matching_digits(measured.resolution, measured.scale);
}

namespace {

constexpr double kUnit = std::numeric_limits<double>::epsilon();
/// The states come from a run that need not be accurate, only closed.
constexpr double kRunTolerance = 1e-7;
/// Modes make a run costly and have been everywhere soon.
constexpr double kPartOfFlexibleRun = 0.1;

/// What one solver says in a new description, led back to the first one.
struct Answers {
  std::vector<SharedState> states;  // the solver's evaluations
  std::vector<RankReport> reports;
  std::vector<Eigen::Index> columns;  // of the states among all
};

/// One model: states, what both solvers find in them, and the same under every move.
class InvarianceRun {
 public:
  InvarianceRun(Model& model, Solvers solvers, const SolverMakers& makers, const InvarianceOptions& options,
                InvarianceChecks& checks)
      : model_(model),
        layout_(model),
        makers_(makers),
        options_(options),
        checks_(checks),
        owned_(std::move(solvers)),
        solvers_{owned_[0].get(), owned_[1].get()} {}

  void run() {
    checks_.name = model_.name;
    for (const Who who : kBothSolvers) starts_[index(who)].samples = {{solvers_[index(who)]->assemble(), {}, 0.0}};
    const State& start = starts_[index(Who::relative)].samples.front().state;
    if (!find_states(start)) return;
    for (Move& move : moves_of(model_, start, options_.moves, options_.seed)) {
      checks_.moves.push_back({move.name, move.about, move.why_not, move.left, static_cast<int>(move.variants.size())});
      for (const Who who : kBothSolvers) {
        MoveRow& row = checks_.rows.emplace_back();
        row.move = checks_.moves.size() - 1;
        row.who = who;
        row.applies = move.why_not.empty() && !(move.of_cuts && solvers_[index(who)]->cut_joints().empty());
      }
      for (const Variant& variant : move.variants) try_variant(variant, start);
      for (std::size_t who = 0; who < 2; ++who) conclude(row_of(kBothSolvers[who]));
    }
    if (loosest_start_ > 0.0) {
      checks_.notes.push_back(fmt::format(
          "the start is not compared where it differs, by up to {:.1e} of its size: near a singular pose closing knows "
          "it no better",
          loosest_start_));
    }
  }

 private:
  [[nodiscard]] const MovedSolver::Maker& maker_of(Who who) const {
    return who == Who::cartesian ? makers_.cartesian : makers_.relative;
  }

  MoveRow& row_of(Who who) { return checks_.rows[checks_.rows.size() - 2 + static_cast<std::size_t>(index(who))]; }

  /// A run by one solver: by the other one where the first does not finish.
  std::optional<Trajectory> integrate() {
    RunOptions run;
    run.until = options_.until.value_or((model_.is_flexible() ? kPartOfFlexibleRun : 1.0) * model_.run.until);
    run.rtol = kRunTolerance;
    run.samples = options_.samples;
    std::string first_words;
    for (const Who who : {Who::relative, Who::cartesian}) {
      try {
        return solvers_[index(who)]->integrate(run, {});
      } catch (const SolverError& error) {
        if (first_words.empty()) first_words = error.what();
      }
    }
    checks_.failures.push_back(std::move(first_words));
    return std::nullopt;
  }

  bool find_states(const State& start) {
    const std::optional<Trajectory> trajectory = integrate();
    if (!trajectory) return false;
    std::vector<OwnedState> run = run_states({nullptr, &*trajectory}, 1);
    run.front().state = start;
    SharedStates shared = share(solvers_, run);
    SharedStates random = share_random(model_, solvers_, run, options_.seed, options_.random);
    checks_.run_states = static_cast<int>(shared.states.size());
    checks_.random_states = static_cast<int>(random.states.size());
    std::move(random.states.begin(), random.states.end(), std::back_inserter(shared.states));
    const auto refused = run.size() + static_cast<std::size_t>(options_.random) - shared.states.size();
    if (refused > 0)
      checks_.notes.push_back(fmt::format("{} states are left out: one of the solvers refuses them", refused));
    if (shared.states.empty()) {
      checks_.failures.emplace_back("there is no state that both solvers evaluate: see what `concord compare` says");
      return false;
    }
    base_ = weigh(layout_, solvers_, std::move(shared.states), options_.seed);
    if (base_.states.empty()) {
      checks_.failures.push_back(base_.dropped);
      return false;
    }
    for (const std::string& reason : base_.singular) {
      if (reason.empty()) continue;
      checks_.notes.push_back(fmt::format("a singular pose is not judged: {}", reason));
      break;
    }
    scales_ = VecX(static_cast<Eigen::Index>(layout_.quantities().size()));
    const std::vector<Measured> measured = measure(layout_, base_.series);
    for (std::size_t row = 0; row < measured.size(); ++row)
      scales_(static_cast<Eigen::Index>(row)) = measured[row].scale;
    for (const SharedState& state : base_.states) terms_.push_back(term_sizes(layout_, state));
    return true;
  }

  void try_variant(const Variant& variant, const State& start) {
    const Model again = started_in(variant.change.model(started_in(model_, start)), variant.change.state(start));
    for (const Who who : kBothSolvers) {
      if (!row_of(who).applies) continue;
      try {
        MovedSolver moved(variant.change, again, maker_of(who));
        compare_starts(who, moved);
        const Answers answers = ask(who, variant, moved);
        if (answers.states.empty()) continue;
        const Mask unique = unique_in_states(answers.reports);
        const MatX own = measure_own_resolution(layout_, moved, who, answers.states, unique, options_.seed);
        judge(who, variant, answers, own, again);
      } catch (const UnsuitableCut& error) {
        leave_out(who, variant, error);
      } catch (const InputError& error) {
        refuse(who, variant, "the description", error.what());
      } catch (const SolverError& error) {
        refuse(who, variant, "the description", error.what());
      }
    }
  }

  void compare_starts(Who who, MovedSolver& moved) {
    Trajectory again;
    again.samples = {{moved.assemble(), {}, 0.0}};
    const MotionAgreement agreement = compare_motions(model_, {&starts_[index(who)], &again});
    if (agreement.digits < kNeed && is_known_no_better(who, moved, again.samples.front().state)) return;
    MotionAgreement& worst = row_of(who).start;
    if (agreement.digits < worst.digits) worst = agreement;
  }

  /// Near a singular pose closing may know the start itself no better, in one of the descriptions or in both.
  bool is_known_no_better(Who who, MovedSolver& moved, const State& again) {
    const State& start = starts_[index(who)].samples.front().state;
    const double apart = distance(start, again, {model_, start});
    if (apart > std::max(known_from_closing(solvers_[index(who)]->rank(start)), known_from_closing(moved.rank(again))))
      return false;
    loosest_start_ = std::max(loosest_start_, apart);
    return true;
  }

  /// The tree that another cut leaves may be one that has no inertia against some motion: no description of the
  /// machine.
  void leave_out(Who who, const Variant& variant, const UnsuitableCut& error) {
    ++row_of(who).left_out;
    checks_.notes.push_back(fmt::format("{} is not tried: {}", variant.label, error.what()));
  }

  void refuse(Who who, const Variant& variant, const std::string& what, const std::string& words) {
    row_of(who).outcome = Outcome::differ;
    tell(row_of(who), variant, fmt::format("refused: {}: {}", what, words));
  }

  static void tell(MoveRow& row, const Variant& variant, const std::string& words) {
    row.words.push_back(variant.label.empty() ? words : fmt::format("{}: {}", variant.label, words));
  }

  /// Asks a solver in every state that is no singular pose.
  Answers ask(Who who, const Variant& variant, MovedSolver& moved) {
    Answers answers;
    int refused = 0;
    std::string first_words;
    for (std::size_t k = 0; k < base_.states.size(); ++k) {
      if (!base_.singular[k].empty()) continue;
      SharedState state{base_.states[k].state, {}, base_.states[k].row};
      try {
        state.evaluations[index(who)] = moved.evaluate(state.state);
        answers.reports.push_back(moved.rank(state.state));
      } catch (const SolverError& error) {
        if (refused++ == 0) first_words = error.what();
        continue;
      }
      answers.states.push_back(std::move(state));
      answers.columns.push_back(static_cast<Eigen::Index>(k));
    }
    if (refused > 0) refuse(who, variant, fmt::format("{} of {} states", refused, base_.states.size()), first_words);
    return answers;
  }

  /// Where a description says that a quantity is unique: rows of the layout, columns of its states.
  [[nodiscard]] Mask unique_in_states(const std::vector<RankReport>& reports) const {
    Mask unique(static_cast<Eigen::Index>(layout_.quantities().size()), static_cast<Eigen::Index>(reports.size()));
    for (Eigen::Index k = 0; k < unique.cols(); ++k)
      unique.col(k) = unique_rows(layout_, reports[static_cast<std::size_t>(k)]);
    return unique;
  }

  /// One solver under one description, `again`, against itself in the first one.
  void judge(Who who, const Variant& variant, const Answers& answers, const MatX& own, const Model& again) {
    Series series;
    series.spin = base_.series.spin;
    series.values[0] = base_.series.values[index(who)](Eigen::all, answers.columns);
    series.values[1].resize(series.values[0].rows(), series.values[0].cols());
    Mask mask(own.rows(), own.cols());
    MatX resolution(own.rows(), own.cols());
    for (Eigen::Index k = 0; k < own.cols(); ++k) {
      const auto answer = static_cast<std::size_t>(k);
      const Eigen::Index at = answers.columns[answer];
      const State& state = answers.states[answer].state;
      series.times.push_back(state.t);
      series.values[1].col(k) = layout_.observe(state, answers.states[answer].evaluations[index(who)]);
      const VecX floor = kUnit * scales_.cwiseMax(terms_[static_cast<std::size_t>(at)]);
      resolution.col(k) = larger_known(base_.resolution.own[index(who)].col(at), own.col(k)) + floor;
      mask.col(k) = unique_in(who, variant, static_cast<std::size_t>(at), answers.reports[answer]);
    }
    if (!series.values[1].allFinite()) {
      row_of(who).outcome = Outcome::differ;
      return tell(row_of(who), variant, "a result is not a number");
    }
    std::vector<Measured> measured = measure(layout_, series, {&resolution, &mask});
    if (misses(measured)) {
      take_round_off_of_data(who, {}, model_, answers, series.values[0], resolution);
      take_round_off_of_data(who, variant.change, again, answers, series.values[1], resolution);
      measured = measure(layout_, series, {&resolution, &mask});
    }
    take(row_of(who), variant, measured);
  }

  static VecX larger_known(const VecX& one, const VecX& other) {
    return other.array().isNaN().select(other, one.cwiseMax(other));
  }

  [[nodiscard]] static bool misses(const std::vector<Measured>& measured) {
    return std::any_of(measured.begin(), measured.end(),
                       [](const Measured& one) { return one.samples > 0 && one.unexplained_digits < kNeed; });
  }

  /// A description's own numbers hold round-off, too, which no draw of a state shows: raises the resolution by how far
  /// the answers (`said`) move under descriptions that differ from `described` by next to nothing.
  void take_round_off_of_data(Who who, const Change& change, const Model& described, const Answers& answers,
                              const MatX& said, MatX& resolution) {
    constexpr std::uint64_t kNearby = 3;
    for (std::uint64_t k = 0; k < kNearby; ++k) {
      const Change nearby = nearby_frames(described, options_.seed + k);
      try {
        MovedSolver moved(change | nearby, nearby.model(described), maker_of(who));
        for (Eigen::Index column = 0; column < said.cols(); ++column) {
          const State& state = answers.states[static_cast<std::size_t>(column)].state;
          const VecX change_of_answer = (layout_.observe(state, moved.evaluate(state)) - said.col(column)).cwiseAbs();
          resolution.col(column) = resolution.col(column).cwiseMax(change_of_answer);
        }
      } catch (const InputError&) {  // within round-off of what the solver refuses
      } catch (const SolverError&) {
      }
    }
  }

  /// Where a quantity is unique in the first description; tells where the second one says otherwise.
  Eigen::Array<bool, Eigen::Dynamic, 1> unique_in(Who who, const Variant& variant, std::size_t state,
                                                  const RankReport& report) {
    const std::vector<Uniqueness> first = uniqueness_of(layout_, base_.reports[state][index(who)]);
    const std::vector<Uniqueness> second = uniqueness_of(layout_, report);
    Eigen::Array<bool, Eigen::Dynamic, 1> unique(static_cast<Eigen::Index>(first.size()));
    for (std::size_t row = 0; row < first.size(); ++row) {
      unique(static_cast<Eigen::Index>(row)) = first[row] == Uniqueness::unique;
      const bool decided = first[row] != Uniqueness::undecided && second[row] != Uniqueness::undecided;
      if (decided && first[row] != second[row]) note_other_uniqueness(who, variant, layout_.quantities()[row]);
    }
    return unique;
  }

  void note_other_uniqueness(Who who, const Variant& variant, const Quantity& quantity) {
    MoveRow& row = row_of(who);
    row.outcome = Outcome::differ;
    const std::string words = fmt::format("{}, {}: unique in one description only", describe_owner(model_, quantity),
                                          describe_component(quantity));
    const bool is_known = std::any_of(row.words.begin(), row.words.end(),
                                      [&](const std::string& known) { return known.ends_with(words); });
    if (!is_known) tell(row, variant, words);
  }

  void take(MoveRow& row, const Variant& variant, const std::vector<Measured>& measured) const {
    for (std::size_t k = 0; k < measured.size(); ++k) {
      const Measured& one = measured[k];
      ++row.total;
      if (one.samples == 0) continue;
      ++row.judged;
      if (row.nearest && !is_nearer(one, row.nearest->measured)) continue;
      row.nearest = Nearest{layout_.quantities()[k], one, variant.label};
    }
  }

  void conclude(MoveRow& row) const {
    if (row.left_out > 0 && row.left_out == checks_.moves[row.move].variants) row.applies = false;
    if (!row.applies || row.outcome == Outcome::differ) return;
    if (!row.nearest) {
      row.outcome = Outcome::failed;
      row.words.emplace_back("no component was judged");
    } else if (row.nearest->measured.unexplained_digits < kNeed || row.start.digits < kNeed) {
      row.outcome = Outcome::differ;
    }
  }

  Model& model_;
  QuantityLayout layout_;
  const SolverMakers& makers_;
  const InvarianceOptions& options_;
  InvarianceChecks& checks_;
  Solvers owned_;
  std::array<Solver*, 2> solvers_;
  std::array<Trajectory, 2> starts_;  // one sample each
  double loosest_start_ = 0.0;        // the farthest that starts differ within what closing knows
  WeighedStates base_;
  VecX scales_;
  std::vector<VecX> terms_;  // by state
};

}  // namespace

InvarianceChecks check_invariance(Model model, const SolverMakers& makers, const InvarianceOptions& options) {
  InvarianceChecks checks;
  std::string note;
  Solvers solvers = make_solvers_on_one_branch(model, makers, note);
  if (!note.empty()) checks.notes.push_back(note);
  InvarianceRun run(model, std::move(solvers), makers, options, checks);
  try {
    run.run();
  } catch (const SolverError& error) {
    checks.failures.emplace_back(error.what());
  } catch (const IncompleteResult& error) {
    checks.failures.emplace_back(error.what());
  }
  const auto has = [&](Outcome outcome) {
    return std::any_of(checks.rows.begin(), checks.rows.end(),
                       [&](const MoveRow& row) { return row.applies && row.outcome == outcome; });
  };
  const bool judges =
      std::any_of(checks.rows.begin(), checks.rows.end(), [](const MoveRow& row) { return row.applies; });
  if (!judges && checks.failures.empty()) checks.failures.emplace_back("none of the moves applies to the machine");
  if (!checks.failures.empty() || has(Outcome::failed)) {
    checks.outcome = Outcome::failed;
  } else if (has(Outcome::differ)) {
    checks.outcome = Outcome::differ;
  }
  return checks;
}

}  // namespace concord::compare::invariance
