#pragma once

#include <string>

#include "common/evaluation_limit.h"
#include "common/line_watch.h"
#include "common/solver.h"
#include "relative/run/clock_noise.h"
#include "relative/run/drift_watch.h"
#include "relative/run/integrated_system.h"
#include "relative/run/integrated_variables.h"
#include "relative/run/modal_oscillators.h"
#include "relative/run/singularity_watch.h"
#include "relative/start/assembly.h"
#include "relative/start/states.h"

/// What an integrator asks of a machine: rates, weights of errors, projected steps; and the samples of a run.
namespace concord::relative {

/// A machine in one run, at whatever times and integrated numbers its integrator asks for.
class IntegrationRun : public IntegratedSystem {
 public:
  /// From `start`, a closed state at t = 0. Equations and assembly must outlive this object.
  IntegrationRun(Equations& equations, Assembly& assembly, const Coordinates& start, const RunOptions& options,
                 const std::string& integrator);

  [[nodiscard]] const IntegratedVariables& variables() const { return variables_; }
  /// The modes, as oscillators without stiffness yet.
  [[nodiscard]] ModalOscillators modes() const;
  /// Sizes of the integrated coordinates, by which their errors are measured.
  [[nodiscard]] VecX sizes_of_coordinates() const { return sizes_.head(variables_.n_q()); }

  /// ydot(t, y).
  void evaluate(double t, const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> ydot) override;
  /// J = d ydot / dy at (t, y), by differences over what is small beside the machine's own sizes: over what is small
  /// beside a state at rest, rates have more round-off than change.
  void differentiate(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                     Eigen::Ref<MatX> J) override;
  /// The parts of -J that stand between modal coordinates, rates and accelerations.
  void differentiate_modes(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                           Eigen::Ref<MatX> S, Eigen::Ref<MatX> D) override;
  /// The factors of errors in y by which an integrator judges them.
  void weigh(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> weights) const override;
  /// Projects the state that a step has reached onto the closure, and looks at what the step has passed.
  void project(double t, Eigen::Ref<VecX> y) override;
  /// Brings the applied forces to a state.
  void apply_forces(double t, const Eigen::Ref<const VecX>& y);
  /// Counts apart the turns of coordinates that have made many, so that they keep their digits; true if there are any.
  bool count_turns(const Eigen::Ref<VecX>& y);

  /// The state at an output time, projected, with accelerations and wrenches computed anew from it; Euler parameters
  /// near those of `before`. A state that this solver would not take from anyone else is not written: what follows it
  /// would be no motion of the machine.
  Sample take_sample(States& states, double t, const Eigen::Ref<const VecX>& y, const State& before);

  /// Throws what has stopped the run at t, with the time in its text.
  [[noreturn]] static void throw_stopped(double t, const SolverError& error);

  [[nodiscard]] long evaluations() const { return evaluations_; }
  [[nodiscard]] double largest_work() const { return largest_work_; }

 private:
  void follow_elements();
  void require_no_contradiction(double t, const Eigen::Ref<const VecX>& projected);
  void differentiate_by(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot, Eigen::Index k,
                        Eigen::Ref<VecX> column);

  Equations* equations_;
  Assembly* assembly_;
  IntegratedVariables variables_;
  Coordinates coordinates_;
  VecX qdot_;
  VecX column_;
  VecX beside_;  // a state beside the one that is differentiated at
  bool has_work_;
  double rtol_;
  VecX sizes_;
  VecX reached_;  // by a step, before it was projected
  VecX weights_;  // of errors there
  SingularityWatch watch_;
  DriftWatch drift_;
  LineWatch lines_;
  EvaluationLimit evaluation_limit_;
  ClockNoise clock_;
  double largest_work_ = 0.0;
  long evaluations_ = 0;
};

}  // namespace concord::relative
