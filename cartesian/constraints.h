#pragma once

#include <array>
#include <optional>
#include <vector>

#include "cartesian/joint_rows.h"
#include "cartesian/layout.h"
#include "cartesian/marker_kinematics.h"
#include "common/model.h"

/// Constraint equations of all joints and couplings: residuals, Jacobians over the body velocities, gamma.
namespace concord::cartesian {

/// The child's marker seen from the parent's: (d, R), and after that their rates (S10).
void place_relative(const Marker& parent, const Marker& child, RelativeMotion& motion);
void move_relative(const Marker& parent, const Marker& child, RelativeMotion& motion);  // (C13)

/// A joint coordinate that couplings relate, and the value that its turns are counted from.
struct CoupledCoordinate {
  const joints::Read* read = nullptr;
  int word = 0;
  int component = 0;
  int place = 0;       // among the joint's q
  bool turns = false;  // it is an angle known but for full turns
  double known = 0.0;
};

/// A coupling's multiplier acts on a coupled coordinate's row with this factor.
struct CoupledShare {
  int row = 0;  // among the joint's
  int coupling_row = 0;
  double factor = 0.0;
};

/// One joint at the current state. Rows: first what the type forbids, then what it forbids of speeds alone, then its
/// drivers in the order of the model. Behind them, no constraints of their own, the coordinates that couplings relate.
struct JointEquations {
  std::array<Marker, 2> markers;
  RelativeMotion motion;
  Vec3 gap = Vec3::Zero();          // r_Pi - r_Pj, global
  Vec3 linear_bias = Vec3::Zero();  // a_rel at Ydot = 0, parent's joint frame
  Vec3 angular_bias = Vec3::Zero();
  int first_row = 0;
  int n_forbids = 0;
  int first_driver = 0;  // n_forbids and the rows of forbidden speeds
  int n_rows = 0;
  std::optional<int> elevation;    // index of an arm's elevation among the joint's q, if it has one
  std::vector<bool> driver_turns;  // by driver: it moves an angle known but for full turns
  std::vector<CoupledCoordinate> coupled;
  std::vector<CoupledShare> shares;
  std::vector<ConstraintRow> rows;  // n_rows and one for each coupled coordinate
  /// Column k: transposed Jacobian of row k over Y of the side's body, (6 + m) numbers: the generalized force of the
  /// row taken as a wrench at the side's point.
  std::array<MatX, 2> Phi_Y_transposed;

  [[nodiscard]] const Marker& marker(Side side) const { return markers[index(side)]; }
  [[nodiscard]] bool is_driver(int row) const { return row >= first_driver; }
};

/// One coupling at the current state: its row is the weighted sum of the rows of the coordinates that it relates.
struct CouplingEquations {
  struct Term {
    int joint;
    int row;  // among the joint's rows
    double factor;
  };
  int row = 0;
  double offset = 0.0;
  std::vector<Term> terms;
  std::vector<int> bodies;             // moving ones, each once
  std::vector<MatX> Phi_Y_transposed;  // by body: one column
};

/// Constraint rows that follow each other and stand on one moving body: those of a joint on a side, or a coupling's.
struct RowBlock {
  int body;
  int first_row;
  int n_rows;
  int joint;  // -1: a coupling
  Side side;
  int coupling;
  int share;  // of the coupling's bodies
};

class Constraints {
 public:
  Constraints(const Model& model, const Layout& layout);

  [[nodiscard]] int n_rows() const { return n_rows_; }
  /// Whether a row holds for positions too, and not for velocities alone.
  [[nodiscard]] bool holds_positions(int row) const { return holds_positions_[row]; }
  [[nodiscard]] bool is_driver(int row) const { return is_driver_[row]; }
  [[nodiscard]] bool has_nonholonomic_rows() const;
  [[nodiscard]] const JointEquations& joint(int k) const { return joints_[k]; }
  [[nodiscard]] int n_joints() const { return static_cast<int>(joints_.size()); }
  [[nodiscard]] const CouplingEquations& coupling(int g) const { return couplings_[g]; }
  [[nodiscard]] int n_couplings() const { return static_cast<int>(couplings_.size()); }
  [[nodiscard]] const Mat3& rotation(int body) const { return rotations_[body]; }

  /// Points, frames, residuals and Jacobians at positions q: all of them, or of one body and of one joint after its
  /// bodies.
  void place(const Eigen::Ref<const VecX>& q);
  void place_couplings();
  void place_body(int body, const Eigen::Ref<const VecX>& q);
  void place_joint(int k, const Eigen::Ref<const VecX>& q);
  /// Velocities and accelerations at Ydot = 0, for velocities Y; after place().
  void move(const Eigen::Ref<const VecX>& Y);
  void move_joint(int k, const Eigen::Ref<const VecX>& Y);

  /// Joint coordinates (by joint) from which the turns of coupled angles are counted, at most half a turn away, and
  /// which tell the side that an arm stands on.
  void count_turns_from(const std::vector<VecX>& q);
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
  /// Phi_Y Y of row `row` of a block; after move() or move_joint() of the block's joints.
  [[nodiscard]] double row_rate(const RowBlock& block, int row) const;
  /// Places and moves the joints that a block's rows depend on; after place_body().
  void place_and_move(const RowBlock& block, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);
  /// gamma of Phi_Y Ydot = gamma; after move() (C29).
  void write_gamma(double t, Eigen::Ref<VecX> gamma) const;

  /// All rows on all moving bodies; together they are Phi_Y.
  [[nodiscard]] const std::vector<RowBlock>& blocks() const { return blocks_; }
  /// Transposed Jacobian of a block over Y of its body: (6 + m) x its rows.
  [[nodiscard]] Eigen::Ref<const MatX> columns(const RowBlock& block) const;

  /// Multipliers of all rows of joint k and, behind them, of its coupled coordinates, from those of all constraints.
  [[nodiscard]] VecX joint_multipliers(int k, const Eigen::Ref<const VecX>& lambda) const;  // (C42)

  /// Transposed Jacobian over Y of the side's body of any row of a joint, for rows that are no constraints: (6 + m).
  void write_transposed(int joint, Side side, const ConstraintRow& row, Eigen::Ref<VecX> column) const;

  /// Whether every joint is on the branch that its type means; otherwise the index of the first that is not.
  [[nodiscard]] std::optional<int> first_joint_off_branch() const;

 private:
  void add_couplings();
  int find_or_add_coupled(const CouplingTerm& term);
  void allocate();

  const Model& model_;
  const Layout& layout_;
  std::vector<JointEquations> joints_;
  std::vector<CouplingEquations> couplings_;
  std::vector<RowBlock> blocks_;
  std::vector<bool> holds_positions_;
  std::vector<bool> is_driver_;
  std::vector<Mat3> rotations_;
  int n_rows_ = 0;
};

}  // namespace concord::cartesian
