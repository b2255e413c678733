#pragma once

#include "relative/bodies/mobilizer.h"

/// Constraints of the velocity alone, from what a joint type permits of it beside its motion.
namespace concord::relative {

/// Evaluator of the permitted speeds of one joint type: S_v with v_rel = S_v w for every velocity that is possible.
/// They span less than S: rows C^T u = 0 on the joint's speeds hold for velocities and accelerations, and say nothing
/// of positions. In the six directions they read T^T v_rel = 0, T the coordinate wrenches of C: T^T S = C^T, T^T S_v =
/// 0.
class NonholonomicConstraint {
 public:
  /// The motion is the type's and must outlive this object. Throws std::invalid_argument if a permitted speed is none
  /// of the motion, which the page of the type contradicts then.
  NonholonomicConstraint(const joints::JointType& type, const Mobilizer& mobilizer);

  /// Number of rows: n_u minus the number of permitted speeds; 0 for a type without them.
  [[nodiscard]] int n_rows() const { return n_rows_; }

  /// Takes the motion at (q, u). Throws SolverError, with `owner` as the joint's name, if two permitted speeds are one
  /// in this pose.
  void evaluate(const JointMotion& at, const std::string& owner);

  /// n_u x rows, orthonormal with slides counted in Mobilizer::length: C^T u [rad/s].
  [[nodiscard]] const JointSquare& C() const { return C_; }
  /// What the rows add to C^T udot: T^T (Sdot u - Sdot_v w) [rad/s2].
  [[nodiscard]] const JointVector& bias() const { return bias_; }

 private:
  void place_columns(const JointMotion& at);
  [[nodiscard]] JointColumns in_joint_speeds(const JointMotion& at) const;
  [[nodiscard]] JointVector speeds_of(const Vec6& v_rel) const;
  [[nodiscard]] bool complete(const JointColumns& P);

  const Mobilizer* mobilizer_;
  std::vector<joints::PermitSpeed> words_;
  int n_rows_ = 0;
  JointVector units_;   // Mobilizer::length for slides, 1 for turns
  JointColumns S_v_;    // 6 x words
  JointColumns rates_;  // of its columns along the motion
  JointSquare C_;
  JointVector bias_;
};

}  // namespace concord::relative
