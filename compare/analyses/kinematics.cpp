#include "compare/analyses/kinematics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "compare/analyses/branch.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/law_of_time.h"
#include "compare/audit/places.h"
#include "compare/states/states.h"

namespace concord::compare::analyses {

namespace {

/// The shortest step between two outputs is so many halvings of the time between them.
constexpr int kHalvings = 20;
/// Steps that are tried in a whole analysis.
constexpr long kMostSteps = 2'000'000;

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

/// A body turns by at most this in a step [rad], and a driver turns by at most this more or less than is foreseen.
constexpr double kLargestStep = 1.0;

/// How one vector of a body moves from one end of a step to the other: a place, or an orientation by its turns.
struct Way {
  std::array<Vec3, 2> misfits;  // of each end from where the other one foresees it
  std::array<Vec3, 2> rates;
  std::array<Vec3, 2> rates_of_rates;
};

/// Whether a step of h seconds ends where its beginning foresees, and begins where its end does, within a part of the
/// way: a machine that changes to another branch jumps, or turns back.
bool is_smooth(const Way& way, double h, double unit) {
  constexpr double kOfWay = 0.2;
  constexpr double kOfSpeed = 0.1;
  constexpr double kOfChange = 0.6;
  constexpr double kRoundOff = 1e-9;
  const double speeds = way.rates[0].norm() + way.rates[1].norm();
  const double changes = h * (way.rates_of_rates[0].norm() + way.rates_of_rates[1].norm());
  const double misfit = std::max(way.misfits[0].norm(), way.misfits[1].norm());
  if (!(misfit <= kOfWay * h * (speeds + changes) + kRoundOff * unit)) return false;
  const double allowed = kOfSpeed * speeds + kOfChange * changes + kRoundOff * unit / h;
  constexpr double kOfJerk = 4.0;  // 3 for a motion that starts from rest without a jump of its acceleration
  const double jerk = h * (way.rates_of_rates[1] - way.rates_of_rates[0]).norm();
  if (!(jerk <= kOfJerk * speeds + kRoundOff * unit / h)) return false;
  const Vec3 change = way.rates[1] - way.rates[0];
  return (change - h * way.rates_of_rates[0]).norm() <= allowed &&
         (change - h * way.rates_of_rates[1]).norm() <= allowed;
}

Vec3 turn_between(const BodyState& one, const BodyState& other) {
  return rotation_vector_of(rotation_of(other.p) * rotation_of(one.p).transpose());
}

/// Moves a driven machine along its motion, in steps that are chosen by the motion.
class Follower {
 public:
  Follower(const Model& model, Solver& solver, double longest)
      : model_(model),
        solver_(solver),
        blocks_(block_triangular_form(model)),
        length_(model.length_scale()),
        longest_(longest) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const Joint& joint = model.joints[k];
      for (const Driver& driver : joint.drivers) {
        const bool is_length = joints::is_length(joint.type->permits[driver.word], driver.component);
        laws_.push_back({k, first_q(*joint.type, driver.word) + driver.component, is_length ? length_ : 1.0,
                         LawOfTime(driver.law)});
      }
    }
  }

  /// The sample at time t from the one before. A step counts if two of half its length lead to the same state.
  Sample to(double t, const Sample& from) {
    const double shortest = std::ldexp(t - from.state.t, -kHalvings);
    Sample now = from;
    double h = std::min(t - from.state.t, longest_);
    while (now.state.t < t) {
      const bool is_last = now.state.t + h * (1.0 + 1e-9) >= t;
      const double end = is_last ? t : now.state.t + h;
      if (auto next = twice(now, end)) {
        now = std::move(*next);
        h = std::min(2.0 * h, longest_);
        continue;
      }
      h *= 0.5;
      if (h < shortest) refuse(now.state.t, h);
    }
    return now;
  }

 private:
  struct Law {
    std::size_t joint;
    int coordinate;
    double unit;
    LawOfTime law;
  };

  [[noreturn]] void refuse(double t, double h) const {
    throw SolverError(
        fmt::format("{}: kinematics: the machine cannot be followed from t = {:.6g} s on, in steps of {:.1g} s: the "
                    "drivers lead it out of reach or into a singular pose{}",
                    solver_.name(), t, h, trouble_.empty() ? "" : " (" + trouble_ + ")"));
  }

  std::optional<Sample> twice(const Sample& now, double t) {
    const auto whole = step(now, t);
    if (!whole) return std::nullopt;
    const auto half = step(now, 0.5 * (now.state.t + t));
    if (!half) return std::nullopt;
    auto halves = step(*half, t);
    if (!halves || !are_same(whole->state, halves->state)) return std::nullopt;
    return halves;
  }

  /// The sample at time t; nothing if the machine does not close there, or not as it is foreseen.
  std::optional<Sample> step(const Sample& now, double t) {
    const double h = t - now.state.t;
    if (++tried_ > kMostSteps) {
      throw SolverError(
          fmt::format("{}: kinematics: more than {} steps by t = {:.6g} s; the machine moves too fast to be "
                      "followed so long",
                      solver_.name(), kMostSteps, now.state.t));
    }
    if (!moves_little(now, h)) return std::nullopt;
    State guess = predict(model_, now, h);
    guess.t = t;
    if (!obeys_laws(guess)) return std::nullopt;
    try {
      const auto closed = solver_.close(guess);
      if (!closed) return std::nullopt;
      Sample next{*closed, solver_.evaluate(*closed), 0.0};
      if (!is_foreseen(now, guess, next, h)) return std::nullopt;
      if (!are_on_one_branch(model_, blocks_, now.state, next.state)) {
        trouble_ = "a singular pose lies between, beyond which the machine is on another branch";
        return std::nullopt;
      }
      return next;
    } catch (const SolverError& error) {
      trouble_ = error.what();
      return std::nullopt;
    }
  }

  static bool moves_little(const Sample& now, double h) {
    for (std::size_t i = 1; i < now.state.bodies.size(); ++i) {
      const double turn = h * now.state.bodies[i].omega.norm() + 0.5 * h * h * now.evaluation.bodies[i].omegadot.norm();
      if (!(turn <= kLargestStep)) return false;
    }
    return true;
  }

  /// Whether drivers lead to where the step foresees their coordinates; a closing counts turns from there.
  [[nodiscard]] bool obeys_laws(const State& guess) const {
    return std::all_of(laws_.begin(), laws_.end(), [&](const Law& one) {
      return std::abs(one.law.at(guess.t).value - guess.q[one.joint](one.coordinate)) <= kLargestStep * one.unit;
    });
  }

  [[nodiscard]] bool is_foreseen(const Sample& now, const State& guess, const Sample& next, double h) const {
    const State back = predict(model_, next, -h);
    for (std::size_t i = 1; i < guess.bodies.size(); ++i) {
      const BodyState& begin = now.state.bodies[i];
      const BodyState& end = next.state.bodies[i];
      const BodyAcceleration& at_begin = now.evaluation.bodies[i];
      const BodyAcceleration& at_end = next.evaluation.bodies[i];
      const Way place{
          {end.r - guess.bodies[i].r, begin.r - back.bodies[i].r}, {begin.v, end.v}, {at_begin.vdot, at_end.vdot}};
      const Way turn{{turn_between(guess.bodies[i], end), turn_between(back.bodies[i], begin)},
                     {begin.omega, end.omega},
                     {at_begin.omegadot, at_end.omegadot}};
      if (!is_smooth(place, h, length_) || !is_smooth(turn, h, 1.0)) return false;
    }
    return true;
  }

  [[nodiscard]] bool are_same(const State& one, const State& other) const {
    constexpr double kSame = 1e-6;
    for (std::size_t i = 1; i < one.bodies.size(); ++i) {
      if (!((one.bodies[i].r - other.bodies[i].r).norm() <= kSame * length_)) return false;
      if (!(turn_between(one.bodies[i], other.bodies[i]).norm() <= kSame)) return false;
    }
    return true;
  }

  const Model& model_;
  Solver& solver_;
  std::vector<Block> blocks_;  // of the equations for velocities
  double length_;
  double longest_;  // step [s]
  std::vector<Law> laws_;
  long tried_ = 0;
  std::string trouble_;  // in the words of the solver, of the last step that it refused
};

}  // namespace

Trajectory run_kinematics(const Model& model, Solver& solver, const RunOptions& options) {
  Trajectory trajectory;
  refuse_nonholonomic(model);
  const State start = solver.assemble();
  refuse_freedom(model, solver, start);
  trajectory.samples.push_back({start, solver.evaluate(start), 0.0});
  constexpr double kFewest = 512.0;  // steps: of a motion that has no rates where a step begins and ends
  Follower follower(model, solver, options.until / kFewest);
  for (int k = 1; k <= options.samples; ++k) {
    trajectory.samples.push_back(follower.to(options.until * k / options.samples, trajectory.samples.back()));
  }
  return trajectory;
}

}  // namespace concord::compare::analyses
