#include "cartesian/solver.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include "cartesian/closing.h"
#include "cartesian/equations.h"
#include "cartesian/euler_parameters.h"
#include "cartesian/joint_coordinates.h"
#include "cartesian/line_watch.h"
#include "cartesian/pose_watch.h"
#include "cartesian/rank.h"
#include "cartesian/reactions.h"
#include "cartesian/start_search.h"
#include "cartesian/stepper.h"
#include "common/error.h"
#include "common/laws/break_times.h"

namespace concord::cartesian {

namespace {

/// A handed-over state is refused above this closure residual.
constexpr double kClosureAllowed = 1e-12;

constexpr double kHalfTurn = EIGEN_PI;
constexpr double kQuarterTurn = 0.5 * EIGEN_PI;

/// Holds the regimes that tires and stops are in for the time of a run.
struct FrozenRegimes {
  AppliedForces& applied;

  explicit FrozenRegimes(AppliedForces& forces) : applied(forces) { applied.freeze_regimes(true); }
  ~FrozenRegimes() { applied.freeze_regimes(false); }
  FrozenRegimes(const FrozenRegimes&) = delete;
  FrozenRegimes& operator=(const FrozenRegimes&) = delete;
};

/// Refuses a run that would never end: an explicit method on a stiff machine, or a motion into a pose that locks.
class Pace {
 public:
  /// `advice` ends the message: what to do about a stiff machine.
  Pace(double until, std::string advice) : until_(until), advice_(std::move(advice)) {}

  /// Throws SolverError if a thousandth of the run takes too many evaluations.
  void require(double t, long evaluations) {
    constexpr long kMost = 300'000;
    constexpr double kPart = 1e-3;
    if (t - since_ > kPart * until_) {
      since_ = t;
      evaluations_then_ = evaluations;
    }
    if (evaluations - evaluations_then_ <= kMost) return;
    throw SolverError(fmt::format(
        "cartesian: at t = {:.6g} s {} evaluations brought the run {:.1e} s further: the motion locks there, "
        "or is too stiff for this integrator{}",
        t, kMost, t - since_, advice_));
  }

 private:
  double until_;
  std::string advice_;
  double since_ = 0.0;
  long evaluations_then_ = 0;
};

class CartesianSolver : public Solver {
 public:
  explicit CartesianSolver(const Model& model)
      : model_(model),
        equations_(model),
        motion_{VecX::Zero(equations_.layout().n_q()), VecX::Zero(equations_.layout().n_Y()), 0.0} {}

  [[nodiscard]] std::string_view name() const override { return "cartesian"; }

  [[nodiscard]] std::vector<std::string> integrators() const override { return {"gbs", "ida"}; }

  State assemble() override {
    if (start_) return *start_;
    std::vector<VecX> turns = start_coordinates(model_);
    const ClosedStart closed = close_start(equations_, motion_.q, motion_.Y);
    const Closing& closing = closed.closing;
    has_searched_for_its_start_ = closed.searched;
    equations_.constraints().write_turns(turns);
    KeptCount kept = count_kept(equations_, 0.0, motion_.q, motion_.Y, false);
    // Where rows depend on each other, a closed pose may be known to the root of round-off only.
    if (!is_right(kept)) {
      const KeptCount coarse = count_kept(equations_, 0.0, motion_.q, motion_.Y, true);
      if (is_right(coarse)) kept = coarse;
    }
    refuse_wrong_count(kept, closing);
    if (!closing.closed) refuse_open_start(closing);
    refuse_dependent(kept);
    State state = packed(0.0, turns);
    decide_for_the_machine(state);
    start_ = state;
    return state;
  }

  [[nodiscard]] bool has_searched_for_its_start() const override { return has_searched_for_its_start_; }

  std::optional<State> close(const State& guess) override {
    require_rows();
    equations_.layout().unpack(guess, motion_.q, motion_.Y);
    equations_.count_turns_from(guess.q);
    try {
      equations_.update(guess.t, motion_.q, motion_.Y);
      if (is_turned_beyond(kQuarterTurn, guess.q)) {
        seek_turns(equations_, guess.t, closing_modes_, guess.q, motion_.q, motion_.Y);
      }
      if (!close_machine(equations_, guess.t, Hold::constraints, closing_modes_, motion_.q, motion_.Y).closed) {
        return std::nullopt;
      }
      if (is_turned_beyond(kHalfTurn, guess.q)) return std::nullopt;
    } catch (const SolverError&) {
      return std::nullopt;  // a deformation out of range on the way
    }
    std::vector<VecX> turns = guess.q;
    equations_.constraints().write_turns(turns);
    return packed(guess.t, turns);
  }

  Evaluation evaluate(const State& state) override {
    require_rows();
    equations_.layout().unpack(state, motion_.q, motion_.Y);
    equations_.count_turns_from(state.q);
    equations_.update(state.t, motion_.q, motion_.Y);
    refuse_open(state);
    refuse_other_turn(state);
    use_independent_rows(state.t);
    equations_.solve(true);
    refuse_contradiction(state.t);
    return evaluation();
  }

  RankReport rank(const State& state) override {
    equations_.layout().unpack(state, motion_.q, motion_.Y);
    equations_.update(state.t, motion_.q, motion_.Y);
    return report_rank(equations_);
  }

  MatX tangent(const State& state) override {
    equations_.layout().unpack(state, motion_.q, motion_.Y);
    equations_.update(state.t, motion_.q, motion_.Y);
    return permitted_velocities(equations_);
  }

  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    const auto began = std::chrono::steady_clock::now();
    State start = assemble();
    if (options.start) start = *options.start;
    equations_.layout().unpack(start, motion_.q, motion_.Y);
    equations_.count_turns_from(start.q);
    motion_.work = 0.0;
    equations_.update(0.0, motion_.q, motion_.Y);
    if (options.start) refuse_open(start);
    use_independent_rows(0.0);
    const FrozenRegimes held(equations_.applied());
    equations_.solve(true);
    refuse_contradiction(0.0);
    const MotionState first = motion_;
    const std::unique_ptr<Stepper> stepper = make_stepper(options, first);
    LineWatch lines(0.0, equations_.applied(), model_.length_scale());
    PoseWatch watch(equations_, generic_rank_, 0.0, first);
    const bool has_dependent_rows = generic_rank_ < equations_.constraints().n_rows();

    Trajectory trajectory;
    trajectory.samples.reserve(options.samples + 1);
    std::vector<VecX> turns = start.q;
    equations_.measure_terms(0.0, motion_.q);
    std::vector<VecX> speeds = zero_speeds(model_);
    trajectory.samples.push_back(sample(0.0, turns, trajectory.statistics));
    Pace pace(options.until, is_implicit(options) ? "" : ": try --cartesian-integrator ida");
    const std::vector<double> breaks = break_times(model_, options.until);
    auto next_break = breaks.begin();
    double reached = 0.0;
    for (int k = 1; k <= options.samples; ++k) {
      const double t = k == options.samples ? options.until : options.until * k / options.samples;
      while (reached < t) {
        const bool breaks_first = next_break != breaks.end() && *next_break < t;
        reached = step(*stepper, watch, pace, breaks_first ? *next_break : t);
        motion_ = stepper->motion();
        count_turns(reached, turns, speeds);
        lines.follow(reached, equations_.applied());
        const bool has_new_rows = watch.follow(reached, motion_);
        const bool at_break = breaks_first && reached >= *next_break;
        if (at_break) ++next_break;
        if (has_new_rows || at_break) stepper->begin_anew();
      }
      equations_.update(t, motion_.q, motion_.Y);
      equations_.solve(true);
      equations_.project(t, motion_.q, motion_.Y);
      if (has_dependent_rows) close_all_rows(t);
      trajectory.samples.push_back(sample(t, turns, trajectory.statistics));
      if (progress) progress(t);
    }
    trajectory.statistics.steps = stepper->steps();
    trajectory.statistics.evaluations = stepper->evaluations();
    trajectory.statistics.largest_work = stepper->largest_work();
    trajectory.statistics.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    return trajectory;
  }

 private:
  static double step(Stepper& stepper, const PoseWatch& watch, Pace& pace, double t) {
    try {
      const double reached = stepper.step(t);
      pace.require(reached, stepper.evaluations());
      return reached;
    } catch (const SingularPose&) {
      throw;
    } catch (const SolverError& error) {
      watch.explain_stop(error.what());
      throw;
    }
  }

  /// Rows that were left out follow from the others with their round-off magnified: closes the motion in them all.
  void close_all_rows(double t) {
    const Closing closing = close_machine(equations_, t, Hold::constraints, closing_modes_, motion_.q, motion_.Y);
    if (closing.closed) return;
    throw SolverError(
        fmt::format("cartesian: at t = {:.6g} s {} do not close: position residual {:.2g}, velocity residual {:.2g}", t,
                    named_open(closing), closing.position_residual, closing.velocity_residual));
  }

  [[nodiscard]] SourceLocation first_place(const std::vector<std::string>& joints) const {
    for (const Joint& joint : model_.joints) {
      if (!joints.empty() && joint.name == joints.front()) return joint.where;
    }
    return {model_.file, 0, 0};
  }

  static std::string named_open(const Closing& closing) {
    std::string names = fmt::format("joints {}", fmt::join(closing.joints_left_open, ", "));
    if (closing.joints_left_open.empty()) names.clear();
    for (const std::string& coupling : closing.couplings_left_open) {
      names += fmt::format("{}coupling '{}'", names.empty() ? "" : " and ", coupling);
    }
    return names;
  }

  [[nodiscard]] bool keeps_coordinates() const {
    const auto is_kept = [](const WordStart& word) { return word.role_q == StartRole::keep; };
    return std::any_of(model_.joints.begin(), model_.joints.end(), [&](const Joint& joint) {
      return std::any_of(joint.start.begin(), joint.start.end(), is_kept);
    });
  }

  [[noreturn]] void refuse_open_start(const Closing& closing) const {
    const std::string why =
        closing.is_off_branch
            ? fmt::format("joint {} closes turned round: axes that should point the same way point against each other",
                          closing.joints_left_open.front())
            : fmt::format("{} do not close (position residual {:.2g}, velocity residual {:.2g})", named_open(closing),
                          closing.position_residual, closing.velocity_residual);
    const char* said =
        closing.places_closed ? "the start values contradict each other: with what is kept and driven, {}; correct the "
                                "kept values"
        : keeps_coordinates() ? "the start values contradict each other, or the guesses are too far off: with what is "
                                "kept and driven, {}, and other starts round about do no better; correct the kept "
                                "values, or give better guesses"
                              : "the guesses do not lead to a pose that closes: with what is driven, {}, and other "
                                "starts round about do no better; give better guesses of joint coordinates or body "
                                "poses";
    throw InputError(first_place(closing.joints_left_open), fmt::format(fmt::runtime(said), why));
  }

  static bool is_right(const KeptCount& kept) {
    return kept.coordinates == kept.coordinate_freedom && kept.speeds == kept.speed_freedom;
  }

  /// A driven machine is often written in a pose that is easy to write, in which fewer constraints are independent.
  [[nodiscard]] const char* hint_at_singular_start() const {
    const auto is_driven = [](const Joint& joint) { return !joint.drivers.empty(); };
    const bool has_drivers = std::any_of(model_.joints.begin(), model_.joints.end(), is_driven);
    return has_drivers
               ? "; or the start is a singular pose, as a linkage that lies flat or stretched, and only seems to "
                 "have more: start it elsewhere"
               : "";
  }

  void refuse_wrong_count(const KeptCount& kept, const Closing& closing) const {
    // Off the constraints redundant rows look independent: count only where the machine closed.
    if (!closing.closed) return;
    if (is_right(kept)) return;
    const std::string found = fmt::format(
        "the start keeps {} joint coordinates and {} joint speeds, but the machine has", kept.coordinates, kept.speeds);
    if (kept.coordinate_freedom == kept.speed_freedom) {
      throw InputError({model_.file, 0, 0},
                       fmt::format("{} {} independent ones (its rigid degrees of freedom, drivers off): keep exactly "
                                   "{} of each{}",
                                   found, kept.coordinate_freedom, kept.coordinate_freedom, hint_at_singular_start()));
    }
    throw InputError(
        {model_.file, 0, 0},
        fmt::format("{} {} independent coordinates and {} independent speeds (its rigid degrees of freedom, "
                    "drivers off; what must not slip restricts speeds alone): keep exactly as many{}",
                    found, kept.coordinate_freedom, kept.speed_freedom, hint_at_singular_start()));
  }

  void refuse_dependent(const KeptCount& kept) const {
    const bool fixes_places = kept.independent_coordinates == kept.coordinate_freedom;
    if (fixes_places && kept.independent_speeds == kept.speed_freedom) return;
    std::vector<std::string> names;
    for (const Joint& joint : model_.joints) {
      const auto keeps = [](const WordStart& word) {
        return word.role_q == StartRole::keep || word.role_u == StartRole::keep;
      };
      if (std::any_of(joint.start.begin(), joint.start.end(), keeps)) names.push_back(joint.name);
    }
    throw InputError(first_place(names),
                     fmt::format("the coordinates that the start keeps in joints {} depend on each other: {} of {} "
                                 "coordinates and {} of {} speeds are independent",
                                 fmt::join(names, ", "), kept.independent_coordinates, kept.coordinates,
                                 kept.independent_speeds, kept.speeds));
  }

  /// What holds for the machine as a whole: whether closing has to move modes, and the rank of its constraints where it
  /// is not singular. The start alone may be a singular pose; so poses round about are looked at too, closed without
  /// drivers.
  void decide_for_the_machine(const State& start) {
    constexpr int kPoses = 4;
    equations_.layout().unpack(start, motion_.q, motion_.Y);
    equations_.update(start.t, motion_.q, motion_.Y);
    closing_modes_ = modes_are_restricted(equations_) ? Modes::moving : Modes::kept;
    const int n_rows = equations_.constraints().n_rows();
    generic_rank_ = may_lose_rank(model_) ? choose_rows(equations_, n_rows).rank : n_rows;
    if (generic_rank_ == n_rows) return;
    std::mt19937 engine(20);
    for (int pose = 0; pose < kPoses; ++pose) generic_rank_ = std::max(generic_rank_, rank_nearby(start, engine));
    equations_.count_turns_from(start.q);
  }

  /// Rank at a closed pose near the start; 0 if none was found.
  int rank_nearby(const State& start, std::mt19937& engine) {
    constexpr double kFar = 0.2;  // in the machine's units
    const Layout& layout = equations_.layout();
    std::uniform_real_distribution<double> spread(-kFar, kFar);
    VecX q(layout.n_q());
    VecX Y(layout.n_Y());
    layout.unpack(start, q, Y);
    VecX move = VecX::NullaryExpr(layout.n_Y(), [&] { return spread(engine); }).cwiseProduct(equations_.units());
    for (int i = 1; i < layout.n_bodies(); ++i) layout.adot(move, i).setZero();
    layout.displace(move, q);
    Y.setZero();
    equations_.count_turns_from(start.q);
    try {
      if (!close_machine(equations_, start.t, Hold::joints_alone, closing_modes_, q, Y).closed) return 0;
      return choose_rows(equations_, -1).rank;
    } catch (const SolverError&) {
      return 0;  // a deformation out of range on the way
    }
  }

  /// Rows that are independent at the last update, whatever was in use before.
  void use_independent_rows(double t) {
    if (!may_lose_rank(model_)) return;
    const RowChoice choice = choose_rows(equations_, generic_rank_);
    if (choice.rank < generic_rank_) refuse_singular(t, choice.rank);
    equations_.use_rows(choice.independent);
  }

  /// Names what the rows' dependence at this pose rests on.
  [[noreturn]] void refuse_singular(double t, int rank) const {
    constexpr double kRestsOn = 0.1;
    const MatX Z = decide_rank(scaled_jacobian(equations_).matrix).left_null_space;
    std::vector<std::string> names;
    for (Eigen::Index row = 0; row < Z.rows(); ++row) {
      if (Z.row(row).norm() < kRestsOn) continue;
      const std::string name = equations_.name_of(static_cast<int>(row));
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    throw SingularPose(
        fmt::format("cartesian: at t = {:.6g} s the machine is in a singular pose: its constraints have rank {} there, "
                    "{} elsewhere; "
                    "those of {} depend on each other; the motion may branch, and reactions may be unbounded",
                    t, rank, generic_rank_, fmt::join(names, ", ")));
  }

  /// Rows that depend on each other in this pose alone need not agree in what they ask of accelerations.
  void refuse_contradiction(double t) {
    const std::optional<int> row = equations_.contradicted_row();
    if (!row) return;
    throw SingularPose(
        fmt::format("cartesian: at t = {:.6g} s no accelerations obey all constraints: those of {} depend on others in "
                    "this pose and contradict them: the pose is singular, or a driver moves what the joints hold",
                    t, equations_.name_of(*row)));
  }

  void require_rows() {
    if (!start_) assemble();
  }

  /// Refuses a state that its own constraints do not call closed: rows in the machine's units, far from the origin
  /// relative to the distance, whose round-off they carry; velocities relative to the largest.
  void refuse_open(const State& state) {
    if (!motion_.q.allFinite() || !motion_.Y.allFinite()) {
      throw SolverError(fmt::format("cartesian: the state at t = {:.6g} s holds a number that is not finite", state.t));
    }
    equations_.measure_terms(state.t, motion_.q);
    const double position_residual = equations_.largest_residual(equations_.residual());
    const double rate = equations_.largest_velocity_residual_by_reach(equations_.velocity_residual());
    const double allowed_rate = kClosureAllowed * equations_.largest_rate(state.t, motion_.Y);
    double stretch = 0.0;
    for (const BodyState& body : state.bodies) stretch = std::max(stretch, std::abs(body.p.norm() - 1.0));
    if (position_residual <= kClosureAllowed && rate <= allowed_rate && stretch <= kClosureAllowed) return;
    const bool moves = position_residual <= kClosureAllowed;
    throw SolverError(fmt::format(
        "cartesian: the state at t = {:.6g} s is not closed: {} residual {:.2g} (of the machine's length, or rad), "
        "velocities {:.2g} of the largest, Euler parameters {:.2g} off unit length; allowed {:.0e}",
        state.t, equations_.name_of_largest(moves ? equations_.velocity_residual() : equations_.residual()),
        position_residual, rate == 0.0 ? 0.0 : kClosureAllowed * rate / allowed_rate, stretch, kClosureAllowed));
  }

  /// Whether a joint's reading that counts turns is further from its coordinate [rad] than `allowed`.
  [[nodiscard]] bool is_turned_beyond(double allowed, const std::vector<VecX>& q) const {
    const std::optional<TurnError> error = largest_turn_error(equations_, q);
    return error && error->size > allowed;
  }

  /// Refuses a state that stands on another turn of a thread than its coordinates say.
  void refuse_other_turn(const State& state) const {
    const std::optional<TurnError> error = largest_turn_error(equations_, state.q);
    if (!error || !(error->size > kHalfTurn)) return;
    throw SolverError(fmt::format(
        "cartesian: in the state at t = {:.6g} s joint '{}' stands at {:.6g} rad, but its coordinate says {:.6g} rad: "
        "another turn",
        state.t, model_.joints[error->joint].name, error->read, error->known));
  }

  [[nodiscard]] Evaluation evaluation() const {
    const Layout& layout = equations_.layout();
    Evaluation result;
    result.bodies.resize(layout.n_bodies());
    for (int i = 1; i < layout.n_bodies(); ++i) {
      result.bodies[i] = {layout.v(equations_.Ydot(), i), layout.omega(equations_.Ydot(), i),
                          layout.adot(equations_.Ydot(), i)};
    }
    for (std::size_t k = 0; k < model_.joints.size(); ++k) {
      const JointEquations& joint = equations_.constraints().joint(static_cast<int>(k));
      const VecX lambda = equations_.constraints().joint_multipliers(static_cast<int>(k), equations_.lambda());
      result.joints.push_back(
          compute_wrenches(model_.joints[k], joint, lambda, equations_.applied().springs_of(static_cast<int>(k))));
    }
    for (int g = 0; g < equations_.constraints().n_couplings(); ++g) {
      result.couplings.push_back(-equations_.lambda()(equations_.constraints().coupling(g).row));
    }
    for (std::size_t e = 0; e < model_.elements.size(); ++e) {
      result.elements.push_back(equations_.applied().element(static_cast<int>(e)));
    }
    return result;
  }

  /// The motion at the equations' last update, with joint coordinates near `known`.
  [[nodiscard]] State packed(double t, const std::vector<VecX>& known) const {
    State state = equations_.layout().pack(t, motion_.q, motion_.Y);
    state.q = known;
    state.u = zero_speeds(model_);
    read_joint_coordinates(model_, equations_.constraints(), state.q, state.u);
    return state;
  }

  Sample sample(double t, std::vector<VecX>& turns, SolverStatistics& statistics) {
    equations_.update(t, motion_.q, motion_.Y);
    note_residuals(statistics);
    equations_.solve(true);
    Sample result{packed(t, turns), evaluation(), motion_.work};
    turns = result.state.q;
    return result;
  }

  /// At the last update: rows by their sizes, velocities by the largest speed.
  void note_residuals(SolverStatistics& statistics) const {
    double largest = equations_.largest_residual(equations_.residual());
    const double rate = equations_.largest_velocity_residual(equations_.velocity_residual());
    if (rate > 0.0) largest = std::max(largest, rate / equations_.largest_rate(equations_.time(), motion_.Y));
    statistics.max_constraint = std::max(statistics.max_constraint, largest);
  }

  /// Follows the turn angles step by step, so that none passes half a turn unseen.
  void count_turns(double t, std::vector<VecX>& turns, std::vector<VecX>& speeds) {
    equations_.update(t, motion_.q, motion_.Y);
    read_joint_coordinates(model_, equations_.constraints(), turns, speeds);
    equations_.count_turns_from(turns);
  }

  static bool is_implicit(const RunOptions& options) { return options.integrator == "ida"; }

  std::unique_ptr<Stepper> make_stepper(const RunOptions& options, const MotionState& first) {
    const std::string chosen = options.integrator.empty() ? integrators().front() : options.integrator;
    // Errors of single steps add up over a run: each step is held to a part of what is asked, more so where steps are
    // many.
    const Tolerance of_gbs{std::max(0.1 * options.rtol, 3e-15), options.until};
    if (chosen == "gbs") return make_extrapolation_stepper(equations_, first, of_gbs);
    const Tolerance of_ida{std::max(0.01 * options.rtol, 1e-13), options.until};
    if (chosen == "ida") return make_ida_stepper(equations_, first, of_ida);
    throw InputError({model_.file, 0, 0}, fmt::format("cartesian: unknown integrator '{}'; it has {}", chosen,
                                                      fmt::join(integrators(), ", ")));
  }

  const Model& model_;
  Equations equations_;
  MotionState motion_;
  std::optional<State> start_;
  bool has_searched_for_its_start_ = false;
  int generic_rank_ = 0;
  Modes closing_modes_ = Modes::kept;
};

}  // namespace

std::unique_ptr<Solver> make_solver(const Model& model) { return std::make_unique<CartesianSolver>(model); }

}  // namespace concord::cartesian
