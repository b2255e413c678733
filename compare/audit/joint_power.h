#pragma once

#include <array>
#include <vector>

#include "common/results.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"

/// Forces along the coordinates of a joint, for the audit's rules of workless reactions, drivers and laws.
namespace concord::compare {

/// What passes through a joint, as the permitted directions see it.
class JointPower {
 public:
  /// `coupled`: tau of the couplings on the joint.
  JointPower(const Joint& joint, const std::vector<LawOfForce>& springs, const std::array<PlacedFrame, 2>& frames,
             const JointWrenches& wrenches, const VecX& coupled, const VecX& hint, double t);

  /// S^T [F; T] of the reaction, along the speeds that are possible.
  [[nodiscard]] VecX of_reaction() const;

  /// S^T [F; T] - tau, with the total wrench, along the speeds that are possible.
  [[nodiscard]] VecX beyond_tau() const;

  /// What of total minus reaction is no coordinate wrench; lengths in units of `length`.
  [[nodiscard]] Vec6 outside_coordinates(double length) const;

  /// What motors, springs and dampers are told to exert minus their laws, n_u numbers each; then tau minus what is told
  /// of all who act on a speed, couplings included: the driver's share is what their laws leave of S^T [F; T].
  [[nodiscard]] VecX beyond_law() const;

  /// Sizes of what springs and actuators, couplings and all of them exert on each speed, though they may cancel.
  [[nodiscard]] VecX sizes_of_laws(const Joint& joint, const std::vector<LawOfForce>& springs, double t) const;

  /// How far the laws exert other forces here than there.
  [[nodiscard]] VecX change_of_laws(const JointPower& there) const { return change_of_laws(there.by_laws_); }

  /// How far the laws exert other forces where the last digits of the coordinates, coarse after many turns, are others.
  [[nodiscard]] VecX change_with_last_digits(const Joint& joint, const std::vector<LawOfForce>& springs,
                                             double t) const;

 private:
  [[nodiscard]] VecX change_of_laws(const VecX& there) const;

  RelativeMotion relative_;
  JointMotion motion_;
  Vec6 total_;
  Vec6 reaction_;
  const JointWrenches& wrenches_;
  const VecX& coupled_;
  VecX by_laws_;
  Mat6X directions_;
};

}  // namespace concord::compare
