#include "compare/states/states.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "compare/audit/element_laws.h"
#include "compare/audit/places.h"
#include "compare/states/chart.h"

namespace concord::compare {

namespace {

constexpr int kTries = 30;
constexpr int kTriesAlong = 12;
/// Each try starts nearer to the run's state than the one before, and the first a little farther than the one that
/// found the last state.
constexpr double kShrink = 0.8;
constexpr double kGrow = 1.05;
/// At least one of so many perturbed states must be found.
constexpr int kFewestOf = 5;
/// Deflection [of the machine's length] to shake a mode with that the run never moves.
constexpr double kQuietDeflection = 1e-4;

}  // namespace

std::vector<OwnedState> run_states(const std::array<const Trajectory*, 2>& trajectories, int least) {
  std::vector<OwnedState> states;
  const auto rows_of = [&](int who) { return trajectories[who] != nullptr ? trajectories[who]->samples.size() : 0; };
  const std::size_t rows = std::max(rows_of(0), rows_of(1));
  const bool take_both = rows < static_cast<std::size_t>(least);
  for (std::size_t k = 0; k < rows; ++k) {
    const int turn = static_cast<int>(k % 2);
    for (const int who : {turn, 1 - turn}) {
      if (k >= rows_of(who)) continue;
      states.push_back({trajectories[who]->samples[k].state, static_cast<Who>(who), static_cast<int>(k)});
      if (!take_both) break;
    }
  }
  return states;
}

StatePerturbation::StatePerturbation(const Model& model, const std::vector<OwnedState>& run, std::uint64_t seed)
    : draws_(seed), sizes_(model) {
  for (const OwnedState& owned : run) sizes_.take(owned.state);
  // A machine that hardly moves is set in motion as gravity would, or the time of the run.
  const double until = run.empty() ? 0.0 : run.back().state.t;
  sizes_.speed = std::max(sizes_.speed, sizes_.falling);
  if (sizes_.speed == 0.0 && until > 0.0) sizes_.speed = sizes_.length / until;
  sizes_.turning = sizes_.speed / sizes_.length;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const VecX& shapes = sizes_.shapes[i];
    for (int mode = 0; mode < model.bodies[i].n_modes(); ++mode) {
      if (sizes_.modal[i](mode) > 0.0) continue;
      sizes_.modal[i](mode) = shapes(mode) > 0.0 ? kQuietDeflection * sizes_.length / shapes(mode) : 0.0;
      sizes_.modal_rate[i](mode) = sizes_.modal[i](mode) * sizes_.turning;
    }
  }
}

Vec3 StatePerturbation::uniform3() {
  Vec3 v;
  for (double& one : v) one = draws_.next();
  return v;
}

VecX StatePerturbation::within(const VecX& largest) {
  VecX drawn = largest;
  for (double& one : drawn) one *= draws_.next();
  return drawn;
}

State StatePerturbation::perturb(const State& state, double amplitude) {
  constexpr double kMove = 0.05;
  constexpr double kTurn = 0.1;
  State perturbed = state;
  for (std::size_t i = 1; i < perturbed.bodies.size(); ++i) {
    BodyState& body = perturbed.bodies[i];
    body.r += amplitude * kMove * sizes_.length * uniform3();
    const Vec3 turn = amplitude * kTurn * uniform3();
    const Eigen::Quaterniond before(body.p(0), body.p(1), body.p(2), body.p(3));
    const Eigen::Quaterniond after = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * before;
    body.p << after.w(), after.x(), after.y(), after.z();
    body.v += amplitude * kTurn * sizes_.speed * uniform3();
    body.omega += amplitude * kTurn * sizes_.turning * uniform3();
    body.a = within(sizes_.modal[i]);
    body.adot = within(sizes_.modal_rate[i]);
  }
  return perturbed;
}

std::optional<State> StatePerturbation::perturb_along(const Model& model, Solver& solver, const State& state,
                                                      double amplitude) {
  constexpr double kMove = 0.01;
  constexpr double kRate = 0.1;
  Chart chart(model, solver, state);
  const VecX ones = VecX::Ones(chart.n());
  const VecX delta = within(amplitude * kMove * ones);
  return chart.at(delta, chart.rates_at_origin() + within(amplitude * kRate * sizes_.turning * ones));
}

namespace {

/// Hands one state to both solvers; what stands in the way goes to `shared`.
void share_one(const std::array<Solver*, 2>& solvers, const OwnedState& owned, SharedStates& shared) {
  SharedState both{owned.state, {}, owned.row};
  bool accepted = true;
  for (int who = 0; who < 2; ++who) {
    const bool own = who == index(owned.owner);
    const auto said = [&](const SolverError& error) {
      return fmt::format("{} does not accept {} state at t = {:.6g} s: {}", solvers[who]->name(),
                         own ? "its own" : fmt::format("{}'s", solvers[index(owned.owner)]->name()), owned.state.t,
                         error.what());
    };
    try {
      both.evaluations[who] = solvers[who]->evaluate(owned.state);
      continue;
    } catch (const SingularPose& error) {
      shared.singular.emplace_back(error.what());
    } catch (const SolverError& error) {
      if (own) {
        shared.failures.push_back(said(error));
      } else {
        shared.refusals.push_back({owned, said(error)});
      }
    }
    accepted = false;
  }
  if (accepted) shared.states.push_back(std::move(both));
}

}  // namespace

SharedStates share(const std::array<Solver*, 2>& solvers, const std::vector<OwnedState>& run) {
  SharedStates shared;
  shared.states.reserve(run.size());
  for (const OwnedState& owned : run) share_one(solvers, owned, shared);
  return shared;
}

State predict(const Model& model, const Sample& now, double h) {
  State guess = now.state;
  guess.t += h;
  for (std::size_t i = 1; i < guess.bodies.size(); ++i) {
    BodyState& body = guess.bodies[i];
    const BodyAcceleration& rate = now.evaluation.bodies[i];
    body.r += h * body.v + 0.5 * h * h * rate.vdot;
    const Vec3 turn = h * body.omega + 0.5 * h * h * rate.omegadot;
    body.p = turned(body.p, turn);
    body.v += h * rate.vdot;
    body.omega += h * rate.omegadot;
    body.a += h * body.adot + 0.5 * h * h * rate.addot;
    body.adot += h * rate.addot;
  }
  // Turns stay counted because the hints move on with them.
  for (std::size_t e = 0; e < guess.spring_angles.size(); ++e) {
    const auto* spring = std::get_if<TurnSpring>(&model.elements[e].what);
    if (spring == nullptr) continue;
    const TurnMotion turn = motion_of(*spring, now.state, now.state.known_angle(e));
    guess.spring_angles[e] = turn.angle + h * turn.rate;
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const joints::JointType& type = *model.joints[k].type;
    for (int word = 0; word < static_cast<int>(type.permits.size()); ++word) {
      const joints::Permit& permit = type.permits[word];
      if (is_orientation(permit)) continue;
      guess.q[k].segment(first_q(type, word), n_q(permit)) += h * guess.u[k].segment(first_u(type, word), n_u(permit));
    }
  }
  return guess;
}

std::optional<Evaluation> evaluation_unless_refused(Solver& solver, const State& state) {
  try {
    return solver.evaluate(state);
  } catch (const SolverError&) {
    return std::nullopt;
  }
}

bool accepts(Solver& solver, const State& state) { return evaluation_unless_refused(solver, state).has_value(); }

namespace {

/// A neighbour of `base`, closed by `solver`, that its own evaluation accepts. `farthest`: the amplitude to begin with,
/// set for the next.
std::optional<State> neighbour(const Model& model, Solver& solver, StatePerturbation& perturbation, const State& base,
                               double& farthest) {
  double amplitude = farthest;
  for (int attempt = 0; attempt < kTries; ++attempt, amplitude *= kShrink) {
    std::optional<State> closed = solver.close(perturbation.perturb(base, amplitude));
    if (!closed || !accepts(solver, *closed)) continue;
    farthest = std::min(1.0, kGrow * amplitude);
    return closed;
  }
  amplitude = 1.0;
  for (int attempt = 0; attempt < kTriesAlong; ++attempt, amplitude *= 0.5) {
    try {
      std::optional<State> closed = perturbation.perturb_along(model, solver, base, amplitude);
      if (closed && accepts(solver, *closed)) return closed;
    } catch (const SolverError&) {  // a pose on the way that the solver refuses
    }
  }
  return std::nullopt;
}

/// The same by the solver whose turn it is, or by the other one where it finds none.
std::optional<OwnedState> neighbour_by_either(const Model& model, const std::array<Solver*, 2>& solvers, Who first,
                                              StatePerturbation& perturbation, const State& base, double& farthest) {
  for (const Who who : {first, first == Who::cartesian ? Who::relative : Who::cartesian}) {
    if (auto state = neighbour(model, *solvers[index(who)], perturbation, base, farthest))
      return OwnedState{std::move(*state), who};
  }
  return std::nullopt;
}

}  // namespace

SharedStates share_random(const Model& model, const std::array<Solver*, 2>& solvers, const std::vector<OwnedState>& run,
                          std::uint64_t seed, int count) {
  SharedStates shared;
  if (run.empty()) return shared;
  StatePerturbation perturbation(model, run, seed);
  double farthest = 1.0;
  for (int k = 0; k < count; ++k) {
    const auto owner = static_cast<Who>(k % 2);
    const State& base = run[static_cast<std::size_t>(k) * run.size() / static_cast<std::size_t>(count)].state;
    SharedStates drawn;
    for (int draw = 0; draw <= kRedraws && drawn.states.empty(); ++draw) {
      std::optional<OwnedState> owned = neighbour_by_either(model, solvers, owner, perturbation, base, farthest);
      if (!owned) break;
      share_one(solvers, *owned, drawn);
      if (drawn.states.empty()) ++shared.drawn_anew;
    }
    if (!drawn.states.empty()) {
      shared.states.push_back(std::move(drawn.states.front()));
      continue;
    }
    // Singular poses all around say nothing about the closures.
    if (!drawn.refusals.empty())
      shared.refusals.push_back(drawn.refusals.back());
    else if (!drawn.failures.empty())
      shared.failures.push_back(drawn.failures.back());
    else if (!drawn.singular.empty())
      shared.singular.push_back(drawn.singular.back());
    else
      ++shared.left_open;
  }
  const auto found = static_cast<int>(shared.states.size());
  if (shared.left_open > 0 && found * kFewestOf < count) {
    shared.failures.push_back(
        fmt::format("{} of {} states near those of the run are closed by neither solver in {} tries", shared.left_open,
                    count, kTries));
  }
  return shared;
}

}  // namespace concord::compare
