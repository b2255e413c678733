#include "relative/run/integration_run.h"

#include <fmt/format.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/sundials.h"
#include "relative/run/fastest_motion.h"

namespace concord::relative {

namespace {

/// Errors of single steps add up over a run: each is held to this part of the tolerance asked of the run, but not below
/// what round-off lets the formulas see.
constexpr double kStepShare = 0.01;
constexpr double kFinestStep = 2e-15;
/// Work is not held to less than this part of the largest that it has been: the round-off of time itself, in laws that
/// change fast, leaves more in the power of drivers than steps could remove.
constexpr double kFinestWork = 1e-12;

}  // namespace

IntegrationRun::IntegrationRun(Equations& equations, Assembly& assembly, const Coordinates& start,
                               const RunOptions& options, const std::string& integrator)
    : equations_(&equations),
      assembly_(&assembly),
      variables_(equations),
      coordinates_(start),
      qdot_(VecX::Zero(equations.topology().n_q)),
      has_work_(equations.has_drivers() || equations.has_applied_forces() || equations.model().is_flexible()),
      rtol_(integrator == "erk" ? std::max(kStepShare * options.rtol, kFinestStep) : options.rtol),
      sizes_(sizes_of(variables_, equations, start)),
      watch_(equations, assembly),
      lines_("relative", equations.size().length()),
      evaluation_limit_({.solver = "relative",
                         .integrator = integrator,
                         .until = options.until,
                         .most = options.most_evaluations,
                         .foresees_end = options.foresees_end}),
      clock_(equations.model(), variables_.size()) {
  watch_.pass(start);
  follow_elements();
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

void IntegrationRun::differentiate(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                                   Eigen::Ref<MatX> J) {
  constexpr double kRootOfRoundOff = 1.5e-8;
  beside_ = y;
  for (Eigen::Index k = 0; k < y.size(); ++k) {
    if (k == variables_.work()) {
      J.col(k).setZero();  // nothing depends on it
      continue;
    }
    beside_(k) += kRootOfRoundOff * (sizes_(k) + std::abs(y(k)));
    evaluate(t, beside_, J.col(k));
    J.col(k) = (J.col(k) - ydot) / (beside_(k) - y(k));
    beside_(k) = y(k);
  }
}

/// Error weights: rtol of the size for coordinates, so that a tolerance does not grow with the number of turns; of
/// the size and the value for speeds, of the size and the largest value so far for work, which drivers may take back
/// to nothing. None below the round-off of the number itself (R74).
void IntegrationRun::weigh(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> weights) const {
  constexpr double kLeastWeighed = 1e-15;
  const Eigen::Index n_rates = y.size() - variables_.n_q();
  weights = sizes_;
  weights.tail(n_rates) += y.tail(n_rates).cwiseAbs();
  weights(variables_.work()) = 0.0;
  weights = (rtol_ * weights).cwiseMax(kLeastWeighed * y.cwiseAbs()).cwiseMax(clock_.of_step());
  weights(variables_.work()) = std::max(rtol_, kFinestWork) * (sizes_(variables_.work()) + largest_work_);
  weights = weights.cwiseInverse();
}

bool IntegrationRun::count_turns(const Eigen::Ref<VecX>& y) {
  constexpr double kMany = 10.0;
  const VecX more = equations_->kinematics().whole_turns(coordinates_.q, kMany);
  if (more.isZero(0.0)) return false;
  variables_.take_off(more, y);
  watch_.count_turns(more);
  equations_->count_turns(equations_->kinematics().turns() + more);
  return true;
}

void IntegrationRun::project(double t, Eigen::Ref<VecX> y) {
  variables_.unpack(y, coordinates_);
  coordinates_.t = t;
  evaluation_limit_.require(t, evaluations_, [&] { return place_of_cost(*equations_, coordinates_); });
  largest_work_ = std::max(largest_work_, std::abs(y(variables_.work())));
  assembly_->project(coordinates_);
  variables_.pack(coordinates_.q, coordinates_.u, y);
  watch_.pass(coordinates_);
  equations_->loops().keep_rows();
  follow_elements();
  clock_.pass(t, y, [this](double at, const Eigen::Ref<const VecX>& numbers, const Eigen::Ref<VecX>& rates) {
    evaluate(at, numbers, rates);
  });
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
    remember(error);
    throw_stopped(t, last_reason_);
  }
  const JointReactions& reactions = equations_->compute_reactions(*evaluated);
  sample.evaluation = states.write_evaluation(*evaluated, reactions);
  return sample;
}

void IntegrationRun::remember(const SolverError& error) {
  last_reason_ = error.what();
  is_singular_ = dynamic_cast<const SingularPose*>(&error) != nullptr;
  is_costly_ = dynamic_cast<const TooManyEvaluations*>(&error) != nullptr;
  is_spent_ = dynamic_cast<const EvaluationsSpent*>(&error) != nullptr;
}

void IntegrationRun::throw_stopped(double t, const std::string& message) const {
  const std::string& reason = last_reason_.empty() ? message : last_reason_;
  const std::string plain = reason.starts_with("relative: ") ? reason.substr(10) : reason;
  const std::string text = fmt::format("relative: at t = {:.6g} s {}", t, plain);
  const std::string what = plain.starts_with("at t = ") ? "relative: " + plain : text;
  if (is_singular_ && !last_reason_.empty()) throw SingularPose(what);
  if (is_spent_ && !last_reason_.empty()) throw EvaluationsSpent(what);
  if (is_costly_ && !last_reason_.empty()) throw TooManyEvaluations(what);
  throw SolverError(what);
}

namespace {

int right_side(realtype t, N_Vector y, N_Vector ydot, void* user_data) {
  auto& run = *static_cast<IntegrationRun*>(user_data);
  try {
    run.evaluate(t, sundials::view(y), sundials::view(ydot));
    return sundials::view(ydot).allFinite() ? 0 : 1;
  } catch (const SolverError& error) {
    run.remember(error);
    return 1;
  }
}

int jacobian(realtype t, N_Vector y, N_Vector ydot, SUNMatrix matrix, void* user_data, N_Vector /*unused*/,
             N_Vector /*unused*/, N_Vector /*unused*/) {
  auto& run = *static_cast<IntegrationRun*>(user_data);
  Eigen::Map<MatX> J(SUNDenseMatrix_Data(matrix), SUNDenseMatrix_Rows(matrix), SUNDenseMatrix_Columns(matrix));
  try {
    run.differentiate(t, sundials::view(y), sundials::view(ydot), J);
    return J.allFinite() ? 0 : 1;
  } catch (const SolverError& error) {
    run.remember(error);
    return 1;
  }
}

int project_step(realtype t, N_Vector y, void* user_data) {
  auto& run = *static_cast<IntegrationRun*>(user_data);
  try {
    run.project(t, sundials::view(y));
    return 0;
  } catch (const SolverError& error) {
    run.remember(error);
    return -1;
  }
}

int error_weights(N_Vector y, N_Vector weights, void* user_data) {
  static_cast<const IntegrationRun*>(user_data)->weigh(sundials::view(y), sundials::view(weights));
  return 0;
}

}  // namespace

StepperCallbacks callbacks_of(IntegrationRun& run) { return {right_side, project_step, error_weights, jacobian, &run}; }

}  // namespace concord::relative
