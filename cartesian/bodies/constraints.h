#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cartesian/bodies/couplings.h"
#include "cartesian/bodies/indices.h"
#include "cartesian/bodies/joint_equations.h"
#include "cartesian/bodies/layout.h"
#include "common/model.h"

/// Constraint equations of all joints and couplings: residuals, Jacobians over the body velocities, gamma.
///
/// What may be asked for follows from the type: of Constraints what holds in every state, of PlacedConstraints what
/// follows from positions, of MovingConstraints what follows from velocities too. place() and move(), or both at
/// once, alone lead from one to the next.
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

class PlacedConstraints;
class MovingConstraints;

/// The rows of a machine: how many there are, whose they are and on which bodies they stand.
class Constraints {
 public:
  /// Model and layout must outlive the constraints.
  static std::unique_ptr<Constraints> make(const Model& model, const Layout& layout);
  virtual ~Constraints() = default;
  Constraints(const Constraints&) = delete;
  Constraints& operator=(const Constraints&) = delete;

  [[nodiscard]] int n_rows() const { return n_rows_; }
  [[nodiscard]] RowRange rows() const { return {RowIndex(0), n_rows_}; }
  /// Whether a row holds for positions too, and not for velocities alone.
  [[nodiscard]] bool holds_positions(RowIndex row) const { return holds_positions_[row.value]; }
  [[nodiscard]] bool is_driver(RowIndex row) const { return is_driver_[row.value]; }
  [[nodiscard]] bool has_nonholonomic_rows() const;
  [[nodiscard]] IndexRange<JointIndex> joints() const { return joints_.indices(); }
  [[nodiscard]] const JointLayout& joint(JointIndex k) const { return joints_[k]; }
  [[nodiscard]] IndexRange<CouplingIndex> couplings() const { return couplings_.indices(); }
  [[nodiscard]] const CouplingLayout& coupling(CouplingIndex g) const { return couplings_[g]; }
  /// The joint or coupling that a row belongs to, "joint 'A'".
  [[nodiscard]] std::string name_of(RowIndex row) const;
  /// All rows on all moving bodies.
  [[nodiscard]] const std::vector<RowBlock>& blocks() const { return blocks_; }

  /// Joint coordinates (by joint) from which the turns of coupled angles are counted, at most half a turn away, and
  /// which tell the side that an arm stands on.
  void count_turns_from(const std::vector<VecX>& q);
  /// Counts them from where the constraints of another copy of the same machine do.
  void count_turns_as(const Constraints& other);
  /// Writes the coupled coordinates that turns are counted from, others untouched.
  void write_turns(std::vector<VecX>& q) const;

  /// Points, frames, residuals and Jacobians at positions q. What was placed or moved before is overwritten.
  PlacedConstraints& place(const Eigen::Ref<const VecX>& q);
  /// The same, with velocities and accelerations at Ydot = 0 for velocities Y; each row is evaluated once.
  MovingConstraints& place_and_move(const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);

 private:
  friend class PlacedConstraints;  // and no other derives: every object is in truth a MovingConstraints
  friend class MovingConstraints;
  Constraints(const Model& model, const Layout& layout);
  void add_joints();
  void add_couplings();
  void add_blocks();
  void place_body(BodyIndex body, const Eigen::Ref<const VecX>& q);

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

/// Constraints at the positions of the last place().
class PlacedConstraints : public Constraints {
 public:
  [[nodiscard]] const JointEquations& joint(JointIndex k) const { return joints_[k]; }
  [[nodiscard]] const Mat3& rotation(BodyIndex body) const { return rotations_[body]; }
  /// Whether every joint is on the branch that its type means; otherwise the first that is not.
  [[nodiscard]] std::optional<JointIndex> first_joint_off_branch() const;

  /// Phi(q, t); turn angles of drivers modulo full turns; zero where a row holds for velocities alone (C27).
  void write_residual(double t, Eigen::Ref<VecX> residual) const;
  /// Transposed Jacobian of a block over Y of its body: (6 + m) x its rows. All blocks together are Phi_Y.
  [[nodiscard]] Eigen::Ref<const MatX> columns(const RowBlock& block) const;
  /// Terms that a row's residual subtracts, in the row's unit, which its round-off is relative to: the law of a driver
  /// that does not turn, the largest of a coupling's terms without their whole turns; zero for all other rows.
  void write_own_terms(double t, Eigen::Ref<VecX> terms) const;
  /// By row: `reach` where it reads places, whose round-off it carries; 1 where it reads orientations alone.
  void write_reaches(double reach, Eigen::Ref<VecX> reaches) const;

  /// Counts turns on from here.
  void follow_turns();

  /// Velocities and accelerations at Ydot = 0, for velocities Y.
  MovingConstraints& move(const Eigen::Ref<const VecX>& Y);

 private:
  friend class MovingConstraints;
  using Constraints::Constraints;
};

/// Constraints at the positions of the last place() and the velocities of the last move().
class MovingConstraints : public PlacedConstraints {
 public:
  /// Phi_Y Y + Phi_t (C28).
  void write_velocity_residual(double t, Eigen::Ref<VecX> residual) const;
  /// Phi_Y Y of a row of a block, `own` among the block's.
  [[nodiscard]] double row_rate(const RowBlock& block, int own) const;
  /// gamma of Phi_Y Ydot = gamma (C29).
  void write_gamma(double t, Eigen::Ref<VecX> gamma) const;

  /// Places and moves one joint anew, where only its `body` has other positions or velocities.
  void displace(JointIndex joint, BodyIndex body, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);
  /// The same of the joints that a block's rows depend on, where only the block's body has others.
  void displace(const RowBlock& block, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);
  /// The rotation of a body alone, whatever its joints.
  void displace(BodyIndex body, const Eigen::Ref<const VecX>& q) { place_body(body, q); }

 private:
  friend class Constraints;
  using PlacedConstraints::PlacedConstraints;
};

}  // namespace concord::cartesian
