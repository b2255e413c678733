#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cartesian/couplings.h"
#include "cartesian/indices.h"
#include "cartesian/joint_equations.h"
#include "cartesian/layout.h"
#include "common/model.h"

/// Constraint equations of all joints and couplings: residuals, Jacobians over the body velocities, gamma.
namespace concord::cartesian {

/// Constraint rows that follow each other and stand on one moving body: those of a joint on a side, or a coupling's.
struct RowBlock {
  struct OfJoint {
    JointIndex joint;
    Side side;
  };
  struct OfCoupling {
    CouplingIndex coupling;
    int share;  // of the coupling's bodies
  };
  BodyIndex body;
  RowIndex first_row;
  int n_rows;
  std::variant<OfJoint, OfCoupling> owner;

  [[nodiscard]] RowIndex row(int own) const { return first_row + own; }
};

class Constraints {
 public:
  Constraints(const Model& model, const Layout& layout);

  [[nodiscard]] int n_rows() const { return n_rows_; }
  [[nodiscard]] RowRange rows() const { return {RowIndex(0), n_rows_}; }
  /// Whether a row holds for positions too, and not for velocities alone.
  [[nodiscard]] bool holds_positions(RowIndex row) const { return holds_positions_[row.value]; }
  [[nodiscard]] bool is_driver(RowIndex row) const { return is_driver_[row.value]; }
  [[nodiscard]] bool has_nonholonomic_rows() const;
  [[nodiscard]] const JointEquations& joint(JointIndex k) const { return joints_[k]; }
  [[nodiscard]] IndexRange<JointIndex> joints() const { return joints_.indices(); }
  [[nodiscard]] const CouplingEquations& coupling(CouplingIndex g) const { return couplings_[g]; }
  [[nodiscard]] IndexRange<CouplingIndex> couplings() const { return couplings_.indices(); }
  [[nodiscard]] const Mat3& rotation(BodyIndex body) const { return rotations_[body]; }
  /// The joint or coupling that a row belongs to, "joint 'A'".
  [[nodiscard]] std::string name_of(RowIndex row) const;

  /// Points, frames, residuals and Jacobians at positions q.
  void place(const Eigen::Ref<const VecX>& q);
  /// Velocities and accelerations at Ydot = 0, for velocities Y; after place().
  void move(const Eigen::Ref<const VecX>& Y);
  /// Both of one joint, where only its `body` has moved.
  void place_and_move(JointIndex joint, BodyIndex body, const Eigen::Ref<const VecX>& q,
                      const Eigen::Ref<const VecX>& Y);
  /// The same of the joints that a block's rows depend on, where only the block's body has moved.
  void place_and_move(const RowBlock& block, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);
  void place_body(BodyIndex body, const Eigen::Ref<const VecX>& q);

  /// Joint coordinates (by joint) from which the turns of coupled angles are counted, at most half a turn away, and
  /// which tell the side that an arm stands on.
  void count_turns_from(const std::vector<VecX>& q);
  /// Counts them from where the constraints of another copy of the same machine do.
  void count_turns_as(const Constraints& other);
  /// Counts on from the last place().
  void follow_turns();
  /// Writes the coupled coordinates that turns are counted from, others untouched.
  void write_turns(std::vector<VecX>& q) const;
  /// Terms that a row's residual subtracts, in the row's unit, which its round-off is relative to: the law of a driver
  /// that does not turn, the largest of a coupling's terms without their whole turns; zero for all other rows.
  void write_own_terms(double t, Eigen::Ref<VecX> terms) const;
  /// By row: `reach` where it reads places, whose round-off it carries; 1 where it reads orientations alone.
  void write_reaches(double reach, Eigen::Ref<VecX> reaches) const;

  /// Phi(q, t); turn angles of drivers modulo full turns; zero where a row holds for velocities alone (C27).
  void write_residual(double t, Eigen::Ref<VecX> residual) const;
  /// Phi_Y Y + Phi_t; after move() (C28).
  void write_velocity_residual(double t, Eigen::Ref<VecX> residual) const;
  /// Phi_Y Y of a row of a block, `own` among the block's; after move() of the block's joints.
  [[nodiscard]] double row_rate(const RowBlock& block, int own) const;
  /// gamma of Phi_Y Ydot = gamma; after move() (C29).
  void write_gamma(double t, Eigen::Ref<VecX> gamma) const;

  /// All rows on all moving bodies; together they are Phi_Y.
  [[nodiscard]] const std::vector<RowBlock>& blocks() const { return blocks_; }
  /// Transposed Jacobian of a block over Y of its body: (6 + m) x its rows.
  [[nodiscard]] Eigen::Ref<const MatX> columns(const RowBlock& block) const;

  /// Whether every joint is on the branch that its type means; otherwise the first that is not.
  [[nodiscard]] std::optional<JointIndex> first_joint_off_branch() const;

 private:
  void add_joints();
  void add_couplings();
  void add_blocks();

  const Model& model_;
  const Layout& layout_;
  ByJoint<JointEquations> joints_;
  ByCoupling<CouplingEquations> couplings_;
  std::vector<RowBlock> blocks_;
  std::vector<bool> holds_positions_;
  std::vector<bool> is_driver_;
  ByBody<Mat3> rotations_;
  int n_rows_ = 0;
};

}  // namespace concord::cartesian
