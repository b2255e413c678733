#pragma once

#include <memory>
#include <vector>

#include "common/model.h"
#include "common/results.h"

/// A rigid machine built from Simbody's parts. Nothing of Simbody shows here, because its headers cost seconds.
namespace concord::compare::oracle {

/// Forces that no mechanics gives: what the laws of force elements and of joint springs exert in a state.
struct KnownForces {
  std::vector<Wrench> on_bodies;  // at the origins of the bodies, global axes [N, N m]; gravity is not among them
  std::vector<VecX> on_speeds;    // of each joint, n_u numbers, as JointWrenches::tau
};

/// Joints become mobilizers, those along a tree of its own choice directly. A body that several joints hold is split:
/// each further joint carries a part of its mass, and Constraint::Weld joins the parts. Drivers become
/// Constraint::ConstantAcceleration, couplings Constraint::SpeedCoupler, links without mass massless bodies.
class SimbodyMachine {
 public:
  /// Throws NotExpressible (compare/quantities/not_expressible.h) naming the part that Simbody does not know. The model
  /// must outlive it.
  explicit SimbodyMachine(const Model& model);
  ~SimbodyMachine();

  /// As ThirdOpinion::evaluate, without the wrenches of force elements.
  Evaluation evaluate(const State& state, const KnownForces& forces);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace concord::compare::oracle
