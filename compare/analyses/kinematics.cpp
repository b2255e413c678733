#include "compare/analyses/kinematics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/error.h"
#include "common/laws/time_function.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/verdict/prediction.h"

namespace concord::compare::analyses {

namespace {

/// The shortest step between two outputs is so many halvings of the time between them.
constexpr int kHalvings = 17;

void refuse_freedom(const Model& model, Solver& solver, const State& start) {
  const int freedom = solver.rank(start).degrees_of_freedom;
  if (freedom <= 0) return;
  int modes = 0;
  for (const Body& body : model.bodies) modes += body.n_modes();
  const int rigid = freedom - modes;
  if (rigid > 0) {
    throw InputError(
        {model.file, 0, 0},
        fmt::format("kinematics needs a machine whose motion is fully driven, but {} degree{} of freedom {} "
                    "left: drive as many joint coordinates more, or integrate the motion with `concord run`",
                    rigid, rigid == 1 ? "" : "s", rigid == 1 ? "is" : "are"));
  }
  throw InputError({model.file, 0, 0},
                   fmt::format("kinematics needs rigid bodies, but {} modal coordinates move freely: integrate the "
                               "motion with `concord run`",
                               freedom));
}

/// Drivers say speeds of a rolling body or of a knife edge, not where it is: that is an integral.
void refuse_nonholonomic(const Model& model) {
  for (const Joint& joint : model.joints) {
    if (joint.type->nonholonomic_rows() == 0) continue;
    throw InputError(
        {model.file, 0, 0},
        fmt::format("kinematics needs places that follow from the time alone, but joint '{}' ({}) constrains "
                    "speeds: integrate the motion with `concord run` or `concord compare`",
                    joint.name, joint.type->name));
  }
}

/// A body turns by at most this in a step, and stands at most this away from where it was foreseen to be (in radians
/// and in lengths of the machine): so a step stays on its branch and in its turn.
constexpr double kLargestStep = 0.5;
constexpr double kForeseen = 0.1;

bool moves_little(const Sample& now, double h) {
  for (std::size_t i = 1; i < now.state.bodies.size(); ++i) {
    const double turn = h * now.state.bodies[i].omega.norm() + 0.5 * h * h * now.evaluation.bodies[i].omegadot.norm();
    if (!(turn <= kLargestStep)) return false;
  }
  return true;
}

/// Whether drivers lead to where the step foresees their coordinates; a closing counts turns from there.
bool obeys_laws(const Model& model, const State& guess) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    for (const Driver& driver : joint.drivers) {
      const double foreseen = guess.q[k](first_q(*joint.type, driver.word) + driver.component);
      const double unit =
          joints::is_length(joint.type->permits[driver.word], driver.component) ? model.length_scale() : 1.0;
      if (!(std::abs(evaluate(driver.law, guess.t).f - foreseen) <= kLargestStep * unit)) return false;
    }
  }
  return true;
}

bool is_foreseen(const Model& model, const State& guess, const State& closed) {
  for (std::size_t i = 1; i < closed.bodies.size(); ++i) {
    const BodyState& there = guess.bodies[i];
    const BodyState& here = closed.bodies[i];
    if ((here.r - there.r).norm() > kForeseen * model.length_scale()) return false;
    if (rotation_vector_of(rotation_of(here.p) * rotation_of(there.p).transpose()).norm() > kForeseen) return false;
  }
  return true;
}

/// The sample h seconds on; nothing if the machine does not close there, or not near where it is foreseen to be.
std::optional<Sample> step(const Model& model, Solver& solver, const Sample& now, double h, double t) {
  if (!moves_little(now, h)) return std::nullopt;
  State guess = predict(model, now, h);
  guess.t = t;
  if (!obeys_laws(model, guess)) return std::nullopt;
  const auto closed = solver.close(guess);
  if (!closed || !is_foreseen(model, guess, *closed)) return std::nullopt;
  return Sample{*closed, solver.evaluate(*closed), 0.0};
}

/// The sample at time t from the one before, in as many steps as the motion asks for.
Sample go_to(const Model& model, Solver& solver, const Sample& from, double t) {
  const double shortest = std::ldexp(t - from.state.t, -kHalvings);
  Sample now = from;
  double h = t - from.state.t;
  while (now.state.t < t) {
    const bool is_last = now.state.t + h * (1.0 + 1e-9) >= t;
    if (const auto next = step(model, solver, now, is_last ? t - now.state.t : h, is_last ? t : now.state.t + h)) {
      now = *next;
      h *= 2.0;
      continue;
    }
    h *= 0.5;
    if (h >= shortest) continue;
    throw SolverError(
        fmt::format("{}: kinematics: the machine cannot be followed from t = {:.6g} s on, in steps of {:.1g} s; the "
                    "drivers lead it out of reach or into a singular pose, or move it too fast for its outputs",
                    solver.name(), now.state.t, shortest));
  }
  return now;
}

}  // namespace

Trajectory run_kinematics(const Model& model, Solver& solver, const RunOptions& options) {
  Trajectory trajectory;
  const State start = solver.assemble();
  refuse_freedom(model, solver, start);
  refuse_nonholonomic(model);
  trajectory.samples.push_back({start, solver.evaluate(start), 0.0});
  for (int k = 1; k <= options.samples; ++k) {
    trajectory.samples.push_back(go_to(model, solver, trajectory.samples.back(), options.until * k / options.samples));
  }
  return trajectory;
}

}  // namespace concord::compare::analyses
