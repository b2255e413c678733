#include "cartesian/solver.h"

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "cartesian/dynamics/dynamics.h"
#include "cartesian/dynamics/equations.h"
#include "cartesian/dynamics/evaluation.h"
#include "cartesian/rank/closing.h"
#include "cartesian/rank/constraint_rank.h"
#include "cartesian/rank/state_check.h"
#include "cartesian/rank/uniqueness.h"
#include "cartesian/run/run.h"
#include "cartesian/start/start.h"
#include "common/error.h"
#include "common/open_evaluation.h"

namespace concord::cartesian {

namespace {

/// The phases of the solver in their order: the start, what holds for the machine as a whole, and then single states or
/// a run.
class CartesianSolver : public Solver, public OpenEvaluation {
 public:
  explicit CartesianSolver(const Model& model)
      : equations_(model),
        dynamics_(equations_),
        q_(VecX::Zero(equations_.layout().n_q())),
        Y_(VecX::Zero(equations_.layout().n_Y())) {}

  [[nodiscard]] std::string_view name() const override { return "cartesian"; }

  [[nodiscard]] std::vector<std::string> integrators() const override { return integrator_names(); }

  State assemble() override { return prepared().start.state; }

  [[nodiscard]] bool has_searched_for_its_start() const override { return prepared_ && prepared_->start.searched; }

  std::optional<State> close(const State& guess) override {
    const MachineRank& machine = prepared().machine;
    if (machine.generic < equations_.constraints().n_rows()) {
      if (auto closed = close_near(guess, machine.generic)) return closed;
    }
    return close_near(guess, {});
  }

  Evaluation evaluate(const State& state) override {
    const MachineRank& machine = prepared().machine;
    set_state(state);
    refuse_open(equations_, state, q_, Y_);
    refuse_other_branch(equations_, state);
    has_chosen_rows_ = true;
    return reported_evaluation(equations_, solve_with_independent_rows(dynamics_, machine, &rows_once_clear_));
  }

  Evaluation evaluate_open(const State& state) override {
    const MachineRank& machine = prepared().machine;
    set_state(state);
    // Rows that were independent in the last closed state are so beside it.
    const Solution& solution =
        has_chosen_rows_ ? dynamics_.solve(Pivots::kept) : solve_with_independent_rows(dynamics_, machine);
    return reported_accelerations(equations_, solution);
  }

  RankReport rank(const State& state) override {
    set_state(state);
    return report_rank(equations_);
  }

  MatX tangent(const State& state) override {
    set_state(state);
    return permitted_velocities(equations_);
  }

  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    const auto began = std::chrono::steady_clock::now();
    const Prepared& ready = prepared();
    Trajectory trajectory =
        run(dynamics_, ready.machine, options.start ? *options.start : ready.start.state, options, progress);
    trajectory.statistics.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    return trajectory;
  }

 private:
  /// What every state is judged with.
  struct Prepared {
    Start start;
    MachineRank machine;
  };

  const Prepared& prepared() {
    if (!prepared_) {
      Start start = assemble_start(equations_);
      const MachineRank machine = decide_for_the_machine(equations_, start.state);
      prepared_ = Prepared{std::move(start), machine};
    }
    return *prepared_;
  }

  std::optional<State> close_near(const State& guess, std::optional<int> rank) {
    const Modes modes = prepared().machine.closing_modes;
    require_shape(equations_.model(), guess);
    try {
      set_state(guess);
      if (is_turned_beyond(equations_, kQuarterTurn, guess.q)) {
        seek_turns(equations_, guess.t, modes, guess.q, q_, Y_);
      }
      const Closing closing = close_machine(equations_, guess.t, Hold::constraints, modes, q_, Y_, shortest_, rank);
      if (!closing.closed) return std::nullopt;
      if (is_turned_beyond(equations_, kHalfTurn, guess.q)) return std::nullopt;
    } catch (const SolverError&) {
      return std::nullopt;  // a deformation out of range on the way
    }
    std::vector<VecX> turns = guess.q;
    equations_.constraints().write_turns(turns);
    return reported_state(equations_, q_, Y_, turns);
  }

  /// All that is decided at a state depends on the turns that it counts.
  void set_state(const State& state) {
    require_shape(equations_.model(), state);
    equations_.layout().unpack(state, q_, Y_);
    equations_.count_turns_from(state);
    equations_.update(state.t, q_, Y_);
  }

  Equations equations_;
  Dynamics dynamics_;
  VecX q_;
  VecX Y_;
  std::optional<Prepared> prepared_;
  ShortestSolver shortest_;
  RowsOnceClear rows_once_clear_;
  bool has_chosen_rows_ = false;
};

}  // namespace

std::unique_ptr<Solver> make_solver(const Model& model) { return std::make_unique<CartesianSolver>(model); }

}  // namespace concord::cartesian
