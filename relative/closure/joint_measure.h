#pragma once

#include <vector>

#include "relative/bodies/spatial_basis.h"
#include "relative/bodies/velocity_transformation.h"

/// Measuring a joint between its two points, (R39) to (R43).
namespace concord::relative {

/// Which speeds have values of their own: driven ones, and at the start those that the model keeps. One for each entry
/// of u, nonzero if prescribed.
using PrescribedMask = std::vector<char>;

/// The driven speeds of a model.
PrescribedMask driven_speeds(const Model& model, const Topology& topology);

/// Coordinates, speeds and misfit of one joint measured between two given joint points.
class JointMeasure {
 public:
  /// `prescribed` has n_u entries for the joint's speeds.
  JointMeasure(const Mobilizer& mobilizer, const char* prescribed);

  /// What to do where Newton's method leaves a misfit above 1e-6 (displacements in parts of Mobilizer::length):
  /// nothing; or start from Mobilizer::trial values too and take a pose with less than a tenth of that misfit, so that
  /// q chooses turns and branches wherever it can; or take any pose with less of it by a tenth.
  enum class Restart { never, if_clearly_better, if_better };

  /// Finds the coordinates that are not prescribed so that the motion comes closest to the points: S^T e = 0 by
  /// Newton's method from q, e = [d - d(q); log(R R(q)^T)] in the parent's joint frame (R40). Prescribed coordinates
  /// are taken from q. Unless it never restarts, it gives the pose found the name that q means: see
  /// Mobilizer::choose_chart.
  void find_q(const JointPoint& parent, const JointPoint& child, double* q, Restart restart);

  /// Finds the speeds that are not prescribed, S^T (v_rel - S u) = 0; prescribed speeds are taken from u. After find_q
  /// (R42).
  void find_u(const JointPoint& parent, const JointPoint& child, const double* q, double* u);

  /// By how much speed c, not prescribed, changes when the measured motion does, in the units of both: the length of
  /// its row in the pseudoinverse of S. One where the axes are at right angles, large near a gimbal pose. After find_q.
  [[nodiscard]] double amplification(int c) const;

  [[nodiscard]] const JointMotion& motion_at() const { return at_; }
  /// e and v_rel - S u [m, rad; m/s, rad/s], components in the parent's joint frame.
  [[nodiscard]] const Vec6& position_residual() const { return position_residual_; }
  [[nodiscard]] const Vec6& velocity_residual() const { return velocity_residual_; }

  /// Number of directions that are forbidden or prescribed: 6 minus speeds that are not prescribed.
  [[nodiscard]] int n_rows() const { return 6 - static_cast<int>(free_.size()); }
  /// Of these, the ones in metres; they stand first.
  [[nodiscard]] int n_linear_rows() const {
    return mobilizer_->couples() ? n_rows() : 3 - static_cast<int>(displacing_.size());
  }
  /// T with T^T S_free = 0: only the first n_rows columns are defined. Orthonormal; if a speed both displaces and
  /// rotates, then with torques counted in Mobilizer::length, T^T diag(1, 1 / length^2) T = 1.
  [[nodiscard]] const Mat6& T() const { return T_; }

 private:
  [[nodiscard]] Vec6 weighed(const Vec6& motion) const;
  [[nodiscard]] double unit(int c) const;
  [[nodiscard]] JointColumns free_columns() const;
  [[nodiscard]] JointVector fit(const Vec6& motion) const;
  void fit_separately(const Vec6& motion, JointVector& speeds) const;
  void fit_together(const Vec6& motion, JointVector& speeds) const;
  double newton(const JointPoint& parent, const JointPoint& child, double* q);
  [[nodiscard]] double misfit() const;
  void follow_place(const JointPoint& parent, const JointPoint& child, double* q);
  [[nodiscard]] double size_of(const JointVector& step) const;
  void decompose_columns();
  double look(const JointPoint& parent, const JointPoint& child, const double* q);
  void move(const JointPoint& parent, const JointPoint& child, const double* q);
  double step_length(const JointPoint& parent, const JointPoint& child, const double* q, const JointVector& step);
  void search(const JointPoint& parent, const JointPoint& child, double least, const VecX& given, double* q);
  void compute_complement();
  void complete_together();

  const Mobilizer* mobilizer_;
  std::vector<int> free_;
  std::vector<int> prescribed_;
  std::vector<int> displacing_;  // free speeds that displace, if none both displaces and rotates
  std::vector<int> rotating_;
  JointMotion at_;
  SpatialBasis displacements_;  // of their columns in at_
  SpatialBasis rotations_;
  bool is_decomposed_ = false;
  bool has_settled_ = false;  // newton(), before its steps ran out
  Vec6 position_residual_ = Vec6::Zero();
  Vec6 velocity_residual_ = Vec6::Zero();
  Mat6 T_ = Mat6::Identity();
};

/// A cut joint of a machine and its closure rows T^T.
struct CutJoint {
  JointIndex joint;
  RowIndex first_row;
  JointMeasure measure;
  /// T in global axes (6 x rows): the wrench on the child at P_i of a unit multiplier, with the opposite sign.
  Mat6 T_global = Mat6::Identity();
};

}  // namespace concord::relative
