#include "relative/solver.h"

#include <fmt/format.h>

#include "common/open_evaluation.h"
#include "relative/rank/rank.h"
#include "relative/run/integration.h"
#include "relative/start/states.h"

namespace concord::relative {

namespace {

/// A frame that is no rotation, as when the norm of its axis overflowed, would give a motion without sense.
void require_frames(const Model& model) {
  constexpr double kNoRotation = 1e-9;
  const auto require = [&](const Attachment& side, const SourceLocation& where, const std::string& owner) {
    const double misfit = (side.C.transpose() * side.C - Mat3::Identity()).norm();
    if (misfit <= kNoRotation && side.point_L.allFinite()) return;
    throw InputError(where, fmt::format("{}: the frame of one of its ends is no rotation at a finite place: its axes "
                                        "are off by {:.1e}: give numbers of ordinary size",
                                        owner, misfit));
  };
  for (const Joint& joint : model.joints) {
    for (const Attachment& side : joint.sides) require(side, joint.where, fmt::format("joint '{}'", joint.name));
  }
  for (const ForceElement& element : model.elements) {
    for (const Side side : {Side::parent, Side::child}) {
      const Attachment* end = end_of(element, side);
      if (end != nullptr) require(*end, element.where, fmt::format("force element '{}'", element.name));
    }
  }
}

class RelativeSolver final : public Solver, public OpenEvaluation {
 public:
  explicit RelativeSolver(const Model& model)
      : model_(model), equations_(model_), assembly_(equations_), states_(equations_) {}

  [[nodiscard]] std::string_view name() const override { return "relative"; }

  [[nodiscard]] std::vector<std::string> integrators() const override { return integrator_names(model_); }

  State assemble() override {
    const Coordinates start = assembly_.start();
    equations_.applied_forces().count_turns_from({});
    return states_.write(equations_.move(start.t, start.q, start.u), {});
  }

  [[nodiscard]] bool has_searched_for_its_start() const override { return assembly_.has_searched_for_its_start(); }

  std::optional<State> close(const State& guess) override {
    states_.require_shape(guess);
    try {
      StateMisfit misfit;
      Coordinates coordinates = states_.read(guess, misfit);
      count_turns_of(guess);
      if (!assembly_.close(coordinates) || states_.joint_off_branch(guess, coordinates.q)) return std::nullopt;
      return states_.write(equations_.move(coordinates.t, coordinates.q, coordinates.u), guess);
    } catch (const SolverError&) {
      return std::nullopt;  // a joint without all its motions, or a deformation out of range, at the guess
    }
  }

  Evaluation evaluate(const State& state) override {
    const Coordinates coordinates = read_closed(state);
    assembly_.decide_rank(coordinates);
    const Evaluated& evaluated = compute_accelerations(coordinates);
    assembly_.closure_rank().require_general(coordinates, evaluated);
    assembly_.closure_rank().require_agreeing_rows(coordinates, evaluated);
    const JointReactions& reactions = equations_.compute_reactions(evaluated);
    return states_.write_evaluation(evaluated, reactions);
  }

  Evaluation evaluate_open(const State& state) override {
    const Coordinates coordinates = states_.read_beside(state);
    count_turns_of(state);
    assembly_.decide_rank(coordinates);
    return states_.write_accelerations(compute_accelerations(coordinates));
  }

  RankReport rank(const State& state) override { return analyze_rank(assembly_.scaled(), read_closed(state)); }

  MatX tangent(const State& state) override { return permitted_velocities(assembly_.scaled(), read_closed(state)); }

  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    Coordinates start = assembly_.start();
    equations_.applied_forces().count_turns_from({});
    if (options.start) start = read_closed(*options.start);
    return relative::integrate(equations_, assembly_, states_, start, options, progress);
  }

  [[nodiscard]] std::vector<std::string> cut_joints() const override {
    std::vector<std::string> names;
    for (const int k : equations_.topology().cuts) names.push_back(model_.joints[k].name);
    return names;
  }

 private:
  const Evaluated& compute_accelerations(const Coordinates& coordinates) {
    try {
      return equations_.compute_refined_accelerations(coordinates.t, coordinates.q, coordinates.u);
    } catch (const SingularPose&) {
      assembly_.closure_rank().throw_singular(coordinates, "");
    }
  }

  Coordinates read_closed(const State& state) {
    Coordinates coordinates = states_.read_closed(state);
    count_turns_of(state);
    return coordinates;
  }

  /// All that is computed from now on counts turns as this state does, which `states_` have read last.
  void count_turns_of(const State& state) {
    equations_.count_turns(states_.turns());
    equations_.applied_forces().count_turns_from(state);
  }

  Model model_;
  Equations equations_;
  Assembly assembly_;
  States states_;
};

}  // namespace

std::unique_ptr<Solver> make_solver(const Model& model) {
  require_frames(model);
  return std::make_unique<RelativeSolver>(model);
}

}  // namespace concord::relative
