#pragma once

#include <vector>

#include "relative/joint_measure.h"
#include "relative/permitted_speeds.h"

/// Rows that relate joint speeds and are no loop: couplings, and constraints of the velocity alone.
namespace concord::relative {

/// Size of a coupling's factors, slides counted in `length`: its row is divided by it, and so is free of units.
double size_of(const Coupling& coupling, const Model& model, double length);

/// Sum of factor_k q_k minus the offset, for the coordinates of every joint (q of joint k from first_q of its span),
/// turns that are counted apart included.
double compute_gap(const Coupling& coupling, const Kinematics& kinematics, const VecX& q);

/// The largest |factor_k q_k|, without turns that are counted apart: what round-off of the gap is made of.
double size_of_terms(const Coupling& coupling, const Kinematics& kinematics, const VecX& q);

/// Its rate, sum of factor_k u_k.
double compute_slip(const Coupling& coupling, const Model& model, const Topology& topology, const VecX& u);

/// What one joint adds to the rows of a relation: C^T u. A unit multiplier pulls with coordinate forces -C: in the tree
/// on the joint's speeds; of a cut joint, which has none in the tree, with their coordinate wrench on both bodies.
struct RelatedJoint {
  int joint = 0;
  int cut = -1;    // its place among the cut joints; -1 in the tree
  int link = -1;   // its link in the tree
  JointSquare C;   // n_u x rows
  JointColumns T;  // of a cut joint: coordinate wrenches of C (entries of held speeds left out), 6 x rows, in the
                   // parent's joint frame: T^T v_rel = C^T u
  JointColumns T_global;
};

/// One coupling (a row for q, u and udot) or the constraints of one joint's velocity (rows for u and udot).
struct Relation {
  int first_row = 0;
  int n_rows = 0;
  int coupling = -1;  // its place in the model; -1: a constraint of velocity
  double size = 1.0;  // of a coupling: see size_of
  std::vector<RelatedJoint> joints;
  JointVector bias;  // C^T udot + bias = 0

  [[nodiscard]] bool is_coupling() const { return coupling >= 0; }
};

/// All relations of a machine: first the couplings in the order of the model, then the joints whose types permit less
/// of the velocity than their motion does.
class Relations {
 public:
  /// Rows are counted from `first_row`. The kinematics must outlive this object.
  Relations(const Kinematics& kinematics, const Held& held, int first_row);

  [[nodiscard]] const std::vector<Relation>& all() const { return relations_; }
  [[nodiscard]] bool any() const { return !relations_.empty(); }
  /// Rows that hold for places too: couplings.
  [[nodiscard]] int n_position_rows() const { return n_position_rows_; }
  [[nodiscard]] int n_rows() const { return n_rows_; }

  /// Takes the pose of the kinematics and of the measured cut joints, q and u complete: rows, bias, and misfits of
  /// places and of velocity (free of units, 1/s). Throws SolverError where a joint's permitted speeds are dependent.
  void measure(const std::vector<CutJoint>& cuts, const VecX& q, const VecX& u, VecX& gap, VecX& slip);

  /// Adds C^T udot + bias to `residual`; a_rel - Sdot u of a cut joint as `free_acceleration(cut)` gives it, in the
  /// parent's joint frame, accelerations of the tree and held ones from udot.
  template <class FreeAcceleration>
  void compute_acceleration_residual(const FreeAcceleration& free_acceleration, const VecX& udot, VecX& residual) const;

 private:
  void add_coupling(int number);
  void add_constraint_of_velocity(int joint);
  RelatedJoint& part_of(Relation& relation, int joint);
  [[nodiscard]] const JointMotion& motion_of(const RelatedJoint& part, const std::vector<CutJoint>& cuts) const;
  void measure_cut(RelatedJoint& part, const CutJoint& cut, VecX::SegmentReturnType slip_rows);
  [[nodiscard]] bool is_held(const RelatedJoint& part, int c) const;

  const Kinematics* kinematics_;
  Held held_;
  std::vector<Relation> relations_;
  std::vector<PermittedSpeeds> permitted_;  // of the constraints of velocity, in their order
  int first_row_;
  int n_position_rows_ = 0;
  int n_rows_ = 0;
};

template <class FreeAcceleration>
void Relations::compute_acceleration_residual(const FreeAcceleration& free_acceleration, const VecX& udot,
                                              VecX& residual) const {
  for (const Relation& relation : relations_) {
    auto rows = residual.segment(relation.first_row, relation.n_rows);
    rows = relation.bias;
    for (const RelatedJoint& part : relation.joints) {
      const Span& span = kinematics_->topology().joints[part.joint];
      for (int c = 0; c < span.n_u; ++c) {
        if (part.cut >= 0 && !is_held(part, c)) continue;
        rows += part.C.row(c).transpose() * udot(span.first_u + c);
      }
      if (part.cut >= 0) rows.noalias() += part.T.transpose().lazyProduct(free_acceleration(part.cut));
    }
  }
}

}  // namespace concord::relative
