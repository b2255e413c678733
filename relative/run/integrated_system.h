#pragma once

#include "common/types.h"

namespace concord::relative {

/// What an integrator integrates: y' = f(t, y), on a manifold perhaps.
class IntegratedSystem {
 public:
  virtual ~IntegratedSystem() = default;

  /// ydot = f(t, y). Throws SolverError where it is not defined.
  virtual void evaluate(double t, const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> ydot) = 0;
  /// The factors of errors in y by which a step is judged: it is accepted if their root mean square is at most 1.
  virtual void weigh(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> weights) const = 0;
  /// Takes the state that a step has reached onto the manifold. Throws SolverError if the run must end there.
  virtual void project(double t, Eigen::Ref<VecX> y) = 0;
  /// J = df/dy at (t, y), where f is ydot. Throws SolverError.
  virtual void differentiate(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                             Eigen::Ref<MatX> J) = 0;
  /// Of modes with coordinates a and rates adot, S = -d(addot)/da and D = -d(addot)/d(adot) at (t, y), where f is ydot.
  /// Throws SolverError.
  virtual void differentiate_modes(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                                   Eigen::Ref<MatX> S, Eigen::Ref<MatX> D) = 0;
};

}  // namespace concord::relative
