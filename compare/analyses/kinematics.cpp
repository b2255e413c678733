#include "compare/analyses/kinematics.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/error.h"
#include "compare/audit/joint_motion.h"
#include "compare/verdict/prediction.h"

namespace concord::compare::analyses {

namespace {

/// Steps between two outputs may be halved so often.
constexpr int kHalvings = 8;

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

/// The sample at time t from the one before, in as many steps as Newton's method needs.
Sample go_to(const Model& model, Solver& solver, const Sample& from, double t) {
  double h = t - from.state.t;
  for (int halvings = 0; halvings <= kHalvings; ++halvings, h *= 0.5) {
    const int steps = 1 << halvings;
    Sample at = from;
    bool closed = true;
    for (int step = 1; step <= steps && closed; ++step) {
      State guess = predict(model, at, h);
      guess.t = step == steps ? t : from.state.t + step * h;
      const auto state = solver.close(guess);
      closed = state.has_value();
      if (closed) at = {*state, solver.evaluate(*state), 0.0};
    }
    if (closed) return at;
  }
  throw SolverError(
      fmt::format("{}: kinematics: the machine cannot be closed between t = {:.6g} s and t = {:.6g} s; "
                  "the drivers lead it out of reach or into a singular pose",
                  solver.name(), from.state.t, t));
}

}  // namespace

Trajectory run_kinematics(const Model& model, Solver& solver, const RunOptions& options) {
  Trajectory trajectory;
  const State start = solver.assemble();
  refuse_freedom(model, solver, start);
  trajectory.samples.push_back({start, solver.evaluate(start), 0.0});
  for (int k = 1; k <= options.samples; ++k) {
    trajectory.samples.push_back(go_to(model, solver, trajectory.samples.back(), options.until * k / options.samples));
  }
  return trajectory;
}

}  // namespace concord::compare::analyses
