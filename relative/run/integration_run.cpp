#include "relative/run/integration_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "relative/run/fastest_motion.h"

namespace concord::relative {

namespace {

/// Errors of single steps add up over a run: each is held to this part of the tolerance asked of the run, but not below
/// what round-off lets the formulas see. A decade of it costs a fifth more steps.
constexpr double kStepShare = 5e-4;
constexpr double kFinestStep = 2e-15;

}  // namespace

IntegrationRun::IntegrationRun(Equations& equations, Assembly& assembly, const Coordinates& start,
                               const RunOptions& options, const std::string& integrator)
    : equations_(&equations),
      assembly_(&assembly),
      variables_(equations),
      coordinates_(start),
      qdot_(VecX::Zero(equations.topology().n_q)),
      has_work_(equations.has_drivers() || equations.has_applied_forces() || equations.model().is_flexible()),
      rtol_(integrator == "adams" ? std::max(kStepShare * options.rtol, kFinestStep) : options.rtol),
      sizes_(sizes_of(variables_, equations, start)),
      reached_(VecX::Zero(variables_.size())),
      weights_(VecX::Zero(variables_.size())),
      watch_(equations, assembly),
      drift_(variables_.size()),
      lines_("relative", equations.size().length()),
      evaluation_limit_({.solver = "relative",
                         .integrator = integrator,
                         .until = options.until,
                         .most = options.most_evaluations,
                         .foresees_end = options.foresees_end}),
      clock_(equations.model(), variables_.size()) {
  column_ = VecX::Zero(variables_.size());
  variables_.pack(start.q, start.u, reached_);
  drift_.stand_at(reached_);
  watch_.pass(start);
  follow_elements();
}

/// In units in which stiffnesses are one, S is nearly symmetric, so that its eigenvectors are far from dependent.
ModalOscillators IntegrationRun::modes() const {
  VecX units = VecX::Ones(static_cast<Eigen::Index>(variables_.modal_coordinates().size()));
  Eigen::Index at = 0;
  for (const Body& body : equations_->model().bodies) {
    for (int k = 0; k < body.n_modes(); ++k, ++at) {
      const double stiffness = body.modal->stiffness(k, k);
      const double largest = body.modal->stiffness.diagonal().maxCoeff();
      if (largest > 0.0) units(at) = 1.0 / std::sqrt(stiffness > 0.0 ? stiffness : largest);
    }
  }
  return {variables_.modal_coordinates(), variables_.modal_rates(), units};
}

void IntegrationRun::evaluate(double t, const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> ydot) {  // (R73)
  ++evaluations_;
  variables_.unpack(y, coordinates_);
  const Evaluated& evaluated = equations_->compute_accelerations(t, coordinates_.q, coordinates_.u);
  equations_->applied_forces().require_seen_turns();
  equations_->compute_qdot(equations_->motion(), qdot_);
  variables_.pack(qdot_, evaluated.udot(), ydot);
  ydot(variables_.work()) = has_work_ ? equations_->power(evaluated) : 0.0;
}

void IntegrationRun::differentiate_by(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                                      Eigen::Index k, Eigen::Ref<VecX> column) {
  constexpr double kRootOfRoundOff = 1.5e-8;
  beside_ = y;
  beside_(k) += kRootOfRoundOff * (sizes_(k) + std::abs(y(k)));
  evaluate(t, beside_, column);
  column = (column - ydot) / (beside_(k) - y(k));
}

void IntegrationRun::differentiate(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                                   Eigen::Ref<MatX> J) {
  for (Eigen::Index k = 0; k < y.size(); ++k) {
    if (k == variables_.work()) {
      J.col(k).setZero();  // nothing depends on it
    } else {
      differentiate_by(t, y, ydot, k, J.col(k));
    }
  }
}

void IntegrationRun::differentiate_modes(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                                         Eigen::Ref<MatX> S, Eigen::Ref<MatX> D) {
  const std::vector<int>& rates = variables_.modal_rates();
  const auto write = [&](const std::vector<int>& by, Eigen::Ref<MatX> matrix) {
    for (std::size_t k = 0; k < by.size(); ++k) {
      differentiate_by(t, y, ydot, by[k], column_);
      for (std::size_t i = 0; i < rates.size(); ++i) matrix(i, k) = -column_(rates[i]);
    }
  };
  write(variables_.modal_coordinates(), S);
  write(rates, D);
}

/// Error weights: rtol of the size for coordinates, so that a tolerance does not grow with the number of turns; of
/// the size and the value for speeds, of the size and the largest value so far for work, which drivers may take back
/// to nothing. None below the round-off of the number itself (R74).
void IntegrationRun::weigh(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> weights) const {
  constexpr double kLeastWeighed = 1e-15;
  const Eigen::Index n_rates = y.size() - variables_.n_q();
  weights = sizes_;
  weights.tail(n_rates) += y.tail(n_rates).cwiseAbs();
  weights(variables_.work()) = sizes_(variables_.work()) + largest_work_;
  weights = (rtol_ * weights).cwiseMax(kLeastWeighed * y.cwiseAbs()).cwiseMax(clock_.of_step());
  weights = weights.cwiseInverse();
}

bool IntegrationRun::count_turns(const Eigen::Ref<VecX>& y) {
  constexpr double kMany = 10.0;
  const VecX more = equations_->kinematics().whole_turns(coordinates_.q, kMany);
  if (more.isZero(0.0)) return false;
  variables_.take_off(more, y);
  drift_.stand_at(y);
  watch_.count_turns(more);
  equations_->count_turns(equations_->kinematics().turns() + more);
  return true;
}

void IntegrationRun::project(double t, Eigen::Ref<VecX> y) {
  variables_.unpack(y, coordinates_);
  coordinates_.t = t;
  evaluation_limit_.require(t, evaluations_, [&] { return place_of_cost(*equations_, coordinates_); });
  largest_work_ = std::max(largest_work_, std::abs(y(variables_.work())));
  reached_ = y;
  assembly_->project(coordinates_);
  variables_.pack(coordinates_.q, coordinates_.u, y);
  require_no_contradiction(t, y);
  watch_.pass(coordinates_);
  equations_->loops().keep_rows();
  follow_elements();
  clock_.pass(t, y, [this](double at, const Eigen::Ref<const VecX>& numbers, const Eigen::Ref<VecX>& rates) {
    evaluate(at, numbers, rates);
  });
}

/// Refuses accelerations that lead off the constraints, and names what they leave most.
void IntegrationRun::require_no_contradiction(double t, const Eigen::Ref<const VecX>& projected) {
  const Closure& closure = equations_->closure();
  if (closure.n_rows() == 0) return;
  weigh(reached_, weights_);
  if (drift_.pass(reached_, projected, weights_)) return;
  variables_.unpack(reached_, coordinates_);
  equations_->move(t, coordinates_.q, coordinates_.u);
  const VecX positions = closure.position_residual().cwiseQuotient(closure.row_units().head(closure.n_position_rows()));
  const VecX speeds =
      closure.velocity_residual().cwiseQuotient(closure.row_units()) / equations_->size().rate_at(coordinates_.u);
  const bool by_place = largest_entry(positions) > largest_entry(speeds);
  throw SolverError(fmt::format(
      "the accelerations contradict the constraints, most of all {}: the projection onto these makes up {:.1e} of the "
      "motion, where a motion that obeys them leaves it errors of integration alone: a fault of the program, or of "
      "what a joint type or a law says of its own rates",
      closure.worst_place(by_place ? positions : speeds), drift_.part()));
}

void IntegrationRun::apply_forces(double t, const Eigen::Ref<const VecX>& y) {
  variables_.unpack(y, coordinates_);
  equations_->update_forces(t, coordinates_.q, coordinates_.u);
}

/// What line springs and turn springs tell from motion to motion: where ends meet, and turns.
void IntegrationRun::follow_elements() {
  AppliedForces& forces = equations_->applied_forces();
  if (!forces.has_line_springs() && !forces.has_turn_springs()) return;
  equations_->update_forces(coordinates_.t, coordinates_.q, coordinates_.u);
  forces.follow_turns();
  if (forces.has_line_springs()) lines_.pass(coordinates_.t, forces.lines(coordinates_.t));
}

namespace {

/// While it lives, contacts take the regimes of the state that they are asked in, as they do for any state by itself.
/// An event may fall on a sample: the step that led there kept the regime before it.
struct FreeContacts {
  AppliedForces& forces;
  std::optional<AppliedForces::ContactRegimes> of_step;

  explicit FreeContacts(AppliedForces& all) : forces(all) {
    if (!forces.has_regimes()) return;
    of_step = forces.contact_regimes();
    forces.free_regimes();
  }
  ~FreeContacts() {
    if (of_step) forces.freeze_regimes(*of_step);
  }
  FreeContacts(const FreeContacts&) = delete;
  FreeContacts& operator=(const FreeContacts&) = delete;
};

}  // namespace

Sample IntegrationRun::take_sample(States& states, double t, const Eigen::Ref<const VecX>& y, const State& before) {
  coordinates_.t = t;
  variables_.unpack(y, coordinates_);
  Sample sample;
  sample.work = y(variables_.work());
  const FreeContacts contacts(equations_->applied_forces());
  const Evaluated* evaluated = nullptr;
  try {
    lines_.settle();
    assembly_->project(coordinates_);
    evaluated = &equations_->compute_accelerations(t, coordinates_.q, coordinates_.u);
    assembly_->closure_rank().require_general(coordinates_, *evaluated);
    assembly_->closure_rank().require_agreeing_rows(coordinates_, *evaluated);
    sample.state = states.write(equations_->motion(), before);
    (void)states.read_closed(sample.state);
  } catch (const SolverError& error) {
    throw_stopped(t, error);
  }
  const JointReactions& reactions = equations_->compute_reactions(*evaluated);
  sample.evaluation = states.write_evaluation(*evaluated, reactions);
  return sample;
}

void IntegrationRun::throw_stopped(double t, const SolverError& error) {
  const std::string reason = error.what();
  const std::string plain = reason.starts_with("relative: ") ? reason.substr(10) : reason;
  const std::string text = fmt::format("relative: at t = {:.6g} s {}", t, plain);
  const std::string what = plain.starts_with("at t = ") ? "relative: " + plain : text;
  if (dynamic_cast<const SingularPose*>(&error) != nullptr) throw SingularPose(what);
  if (dynamic_cast<const EvaluationsSpent*>(&error) != nullptr) throw EvaluationsSpent(what);
  if (dynamic_cast<const TooManyEvaluations*>(&error) != nullptr) throw TooManyEvaluations(what);
  throw SolverError(what);
}

}  // namespace concord::relative
