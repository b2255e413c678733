#include "compare/states/branch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/error.h"
#include "common/joints/facts.h"
#include "common/joints/named_coordinates.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/kept_start.h"
#include "compare/audit/places.h"
#include "compare/states/states.h"

namespace concord::compare {

namespace {

/// Whether the resistance of a law depends on its coordinate, and not on the speed or the time alone.
bool reads_coordinate(const ForceLaw& law) {
  return law.stiffness != 0.0 || law.spring_table || law.lower || law.upper;
}

bool is_coupled(const Model& model, std::size_t joint, int word, int component) {
  const auto is_it = [&](const CouplingTerm& term) {
    return term.joint == static_cast<int>(joint) && term.word == word && term.component == component;
  };
  return std::any_of(model.couplings.begin(), model.couplings.end(), [&](const Coupling& coupling) {
    return std::any_of(coupling.terms.begin(), coupling.terms.end(), is_it);
  });
}

}  // namespace

bool whole_turns_change_nothing(const Model& model, std::size_t joint, int word, int component) {
  const Joint& its = model.joints[joint];
  const joints::StatedCoordinates stated =
      joints::stated_coordinates(its.type->permits[static_cast<std::size_t>(word)]);
  if (stated[component].kind != joints::CoordinateKind::angle || !stated[component].axis) return false;
  const bool is_sprung = std::any_of(its.springs.begin(), its.springs.end(), [&](const JointSpring& spring) {
    return spring.word == word && spring.component == component && reads_coordinate(spring.law);
  });
  return !is_sprung && driver_of(its, word, component) == nullptr && !is_coupled(model, joint, word, component);
}

double with_turns_of(double near, double angle) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return angle + kTurn * std::round((near - angle) / kTurn);
}

namespace {

/// Starts farther apart than this [of the machine's length, rad] stand on different branches; where rows depend on each
/// other, a start is known to the root of round-off only.
constexpr double kOneBranch = 1e-6;

/// A start, or why a solver refuses the model.
struct Assembled {
  std::optional<State> state;
  std::optional<InputError> refusal;
};

Assembled assembled(Solver& solver) {
  try {
    return {solver.assemble(), std::nullopt};
  } catch (const InputError& error) {
    return {std::nullopt, error};
  }
}

/// Calls `use` with joint, named coordinate, word of the start and both values of each coordinate; of a ball with the
/// angle between both orientations, and zero.
template <class Use>
void for_each_pair(const Model& model, const std::vector<VecX>& one, const std::vector<VecX>& other, const Use& use) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const joints::JointType& type = *model.joints[k].type;
    for (const NamedCoordinate& coordinate : named_coordinates(type)) {
      const int q = first_q(type, coordinate.word) + coordinate.component;
      const WordStart& word = model.joints[k].start[static_cast<std::size_t>(coordinate.word)];
      if (coordinate.kind == joints::CoordinateKind::orientation) {
        const Mat3 turn = rotation_of(one[k].segment<4>(q)) * rotation_of(other[k].segment<4>(q)).transpose();
        use(k, coordinate, word, rotation_vector_of(turn).norm(), 0.0);
      } else {
        use(k, coordinate, word, one[k](q), other[k](q));
      }
    }
  }
}

bool is_turn(const Model& model, std::size_t joint, const NamedCoordinate& coordinate) {
  const joints::JointType& type = *model.joints[joint].type;
  const int u = first_u(type, coordinate.word) + coordinate.component;
  return turning_speeds(type)[static_cast<std::size_t>(u)];
}

/// From one value of a coordinate to another [of the machine's length, rad], without whole turns that change nothing.
double difference(const Model& model, std::size_t joint, const NamedCoordinate& at, double from, double to) {
  if (!is_turn(model, joint, at)) return (to - from) / model.length_scale();
  const bool is_one_pose = whole_turns_change_nothing(model, joint, at.word, at.component);
  return (is_one_pose ? with_turns_of(from, to) : to) - from;
}

/// The coordinate in which two starts differ most.
struct Apart {
  double size = 0.0;  // of the machine's length, rad
  std::string text;
  bool counts_differ = false;  // of whole turns that change nothing
};

Apart apart(const Model& model, const State& one, const State& other) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  Apart most;
  for_each_pair(model, one.q, other.q, [&](std::size_t k, const NamedCoordinate& at, const auto&, double a, double b) {
    const bool turns = is_turn(model, k, at);
    const double size = std::abs(difference(model, k, at, a, b));
    if (turns && std::abs(a - b) - size > std::numbers::pi) most.counts_differ = true;
    if (!(size > most.size)) return;
    const std::string name = fmt::format("{} of {}", at.name, model.joints[k].name);
    const double unit = turns ? kDegree : 1.0;
    most.size = size;
    most.text = fmt::format("{} {:.6g} and {:.6g} {}", name, a / unit, b / unit, turns ? "deg" : "m");
    if (at.name.starts_with("ball")) most.text = fmt::format("{} {:.6g} deg apart", name, a / kDegree);
  });
  return most;
}

}  // namespace

bool obeys_the_model(const Model& model, const State& state) { return audit_kept_coordinates(model, state).holds(); }

namespace {

/// Whether one of two starts drops what the model keeps or drives.
bool one_disobeys(const Model& model, const std::array<Assembled, 2>& starts) {
  return std::any_of(starts.begin(), starts.end(),
                     [&](const Assembled& start) { return start.state && !obeys_the_model(model, *start.state); });
}

/// Distances of a start from what the model guesses, and from zero where it says nothing.
struct FromGuesses {
  double said = 0.0;
  double unsaid = 0.0;
};

FromGuesses from_guesses(const Model& model, const State& state) {
  const double length = model.length_scale();
  std::vector<VecX> guesses;
  for (const Joint& joint : model.joints) {
    VecX& q = guesses.emplace_back(VecX::Zero(joint.type->n_q()));
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const VecX& start = joint.start[word].q;
      if (start.size() > 0) q.segment(first_q(*joint.type, static_cast<int>(word)), start.size()) = start;
    }
  }
  FromGuesses sum;
  const auto take = [](double& size, double distance) { size = std::hypot(size, distance); };
  for_each_pair(model, state.q, guesses,
                [&](std::size_t k, const NamedCoordinate& at, const WordStart& word, double a, double b) {
                  if (word.role_q == StartRole::keep) return;
                  const double distance = (a - b) / (is_turn(model, k, at) ? 1.0 : length);
                  take(word.role_q == StartRole::guess ? sum.said : sum.unsaid, distance);
                });
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    if (!model.bodies[i].pose_guess) continue;
    const Pose& guess = *model.bodies[i].pose_guess;
    take(sum.said, (state.bodies[i].r - guess.r).norm() / length);
    take(sum.said, rotation_vector_of(rotation_of(state.bodies[i].p) * guess.A.transpose()).norm());
  }
  return sum;
}

/// Whether the second of two starts is nearer to the guesses.
bool second_is_nearer(const Model& model, const State& one, const State& other) {
  constexpr double kTells = 1e-3;  // of the larger distance
  const FromGuesses a = from_guesses(model, one);
  const FromGuesses b = from_guesses(model, other);
  if (std::abs(a.said - b.said) > kTells * std::max(a.said, b.said)) return b.said < a.said;
  return b.unsaid < a.unsaid;
}

std::string note_of_branches(const Solvers& solvers, const Apart& between, std::string_view nearer) {
  return fmt::format(
      "from the guesses {} and {} assemble different branches ({}); both start from that of {}, which is nearer to the "
      "guesses",
      solvers[0]->name(), solvers[1]->name(), between.text, nearer);
}

[[noreturn]] void refuse_branches(const Model& model, const std::string& where) {
  throw InputError(
      {model.file, 0, 0},
      fmt::format("the guesses do not choose a branch of the machine: the solvers assemble {}; give guesses "
                  "near the one that is meant",
                  where));
}

}  // namespace

Model started_at(const Model& model, const State& state) {
  Model started = model;
  for (std::size_t k = 0; k < started.joints.size(); ++k) {
    Joint& joint = started.joints[k];
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      WordStart& start = joint.start[word];
      if (start.q.size() == 0) continue;  // an arm
      start.q = state.q[k].segment(first_q(*joint.type, static_cast<int>(word)), start.q.size());
      start.role_q = std::max(start.role_q, StartRole::guess);
    }
  }
  for (std::size_t i = 1; i < started.bodies.size(); ++i) {
    started.bodies[i].pose_guess = Pose{state.bodies[i].r, rotation_of(state.bodies[i].p)};
    started.bodies[i].a_start = state.bodies[i].a;
  }
  return started;
}

Solvers make_solvers_on_one_branch(Model& model, const SolverMakers& makers, std::string& note) {
  Solvers solvers{makers.cartesian(model), makers.relative(model)};
  std::array<Assembled, 2> starts;
  try {
    starts = {assembled(*solvers[0]), assembled(*solvers[1])};
  } catch (const SolverError&) {
    return solvers;  // whoever asks it for a start is told why
  }
  if (!starts[0].state && !starts[1].state) throw *starts[0].refusal;
  const bool both = starts[0].state && starts[1].state;
  const Apart between = both ? apart(model, *starts[0].state, *starts[1].state) : Apart{};
  const bool is_one_pose = both && between.size <= kOneBranch;
  if (is_one_pose && !between.counts_differ) return solvers;
  if (one_disobeys(model, starts)) return solvers;
  const auto closes_guesses = [&](std::size_t k) {
    return starts[k].state && !solvers[k]->has_searched_for_its_start();
  };
  std::size_t better = 0;
  if (is_one_pose || (both && closes_guesses(0) == closes_guesses(1))) {
    better = second_is_nearer(model, *starts[0].state, *starts[1].state) ? 1 : 0;
    note = is_one_pose ? "" : note_of_branches(solvers, between, solvers[better]->name());
  } else {
    better = closes_guesses(0) || (!closes_guesses(1) && starts[0].state) ? 0 : 1;
    note = fmt::format("from the guesses {} finds no start; both start from that of {}", solvers[1 - better]->name(),
                       solvers[better]->name());
  }
  const Model as_given = model;
  model = started_at(model, *starts[better].state);
  const std::optional<InputError> first_refusal = starts[1 - better].refusal;
  solvers = {makers.cartesian(model), makers.relative(model)};
  starts = {assembled(*solvers[0]), assembled(*solvers[1])};
  if (!starts[better].state || (!starts[1 - better].state && !first_refusal)) {
    throw *starts[starts[better].state ? 1 - better : better].refusal;
  }
  if (starts[1 - better].state) {
    const Apart most = apart(model, *starts[0].state, *starts[1].state);
    if (most.size <= kOneBranch) return solvers;
    if (accepts(*solvers[1], *starts[0].state) && accepts(*solvers[0], *starts[1].state)) {
      refuse_branches(model, most.text);
    }
  }
  // It does not take the other one's start either, or takes it for open, which is no branch: whoever asks it for its
  // own is told why, or sees in states who is wrong.
  model = as_given;
  note.clear();
  return {makers.cartesian(model), makers.relative(model)};
}

}  // namespace concord::compare
