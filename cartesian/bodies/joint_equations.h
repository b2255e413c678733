#pragma once

#include <array>
#include <optional>
#include <vector>

#include "cartesian/bodies/indices.h"
#include "cartesian/bodies/joint_rows.h"
#include "cartesian/bodies/layout.h"
#include "cartesian/bodies/marker_kinematics.h"
#include "common/model.h"

/// One joint at the current state: its markers, the child's motion seen from the parent, and its rows with their
/// Jacobians over the velocities of both bodies.
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
  RowIndex coupling_row;
  double factor = 0.0;
};

/// Where a joint's rows stand: first what the type forbids, then what it forbids of speeds alone, then the joint's
/// drivers in the order of the model. Behind them, no constraints of their own, the coordinates that couplings relate.
struct JointLayout {
  RowIndex first_row;
  int n_forbids = 0;
  int first_driver = 0;  // n_forbids and the rows of forbidden speeds
  int n_rows = 0;
  int n_u = 0;
  std::optional<int> elevation;    // index of an arm's elevation among the joint's q, if it has one
  std::vector<bool> driver_turns;  // by driver: it moves an angle known but for full turns
  std::vector<CoupledCoordinate> coupled;
  std::vector<CoupledShare> shares;

  /// Of a row among the joint's.
  [[nodiscard]] bool is_driver(int own) const { return own >= first_driver; }
  [[nodiscard]] RowIndex row(int own) const { return first_row + own; }
};

/// The rows at the current state.
struct JointEquations : JointLayout {
  std::array<Marker, 2> markers;
  RelativeMotion motion;
  Vec3 gap = Vec3::Zero();          // r_Pi - r_Pj, global
  Vec3 linear_bias = Vec3::Zero();  // a_rel at Ydot = 0, parent's joint frame
  Vec3 angular_bias = Vec3::Zero();
  std::vector<ConstraintRow> rows;  // n_rows and one for each coupled coordinate
  /// Column k: transposed Jacobian of row k over Y of the side's body, (6 + m) numbers: the generalized force of the
  /// row taken as a wrench at the side's point.
  std::array<MatX, 2> Phi_Y_transposed;

  [[nodiscard]] const Marker& marker(Side side) const { return markers[index(side)]; }
  /// What gradient . a_rel + bias of a row is without the accelerations Ydot.
  [[nodiscard]] double bias_of(const ConstraintRow& row) const {
    return row.over_d.dot(linear_bias) + row.over_rho.dot(angular_bias) + row.bias;
  }
};

/// The equations of a joint whose rows begin at `first_row` and of whose coordinates couplings relate these; sides on
/// ground are placed for good.
JointEquations make_joint_equations(const Joint& stated, const Layout& layout, RowIndex first_row,
                                    std::vector<CoupledCoordinate> coupled);

/// Points, frames, rows and Jacobians at positions q, of bodies with these rotations.
void place_joint(const Joint& stated, const Layout& layout, const ByBody<Mat3>& rotations,
                 const Eigen::Ref<const VecX>& q, JointEquations& joint);
/// Velocities and accelerations at Ydot = 0 of a placed joint, for velocities Y (C14).
void move_joint(const Joint& stated, const Layout& layout, const ByBody<Mat3>& rotations,
                const Eigen::Ref<const VecX>& Y, JointEquations& joint);

/// Both at once.
void place_and_move_joint(const Joint& stated, const Layout& layout, const ByBody<Mat3>& rotations,
                          const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y, JointEquations& joint);

/// Transposed Jacobian over Y of the side's body of any row of a placed joint, for rows that are no constraints.
void write_transposed(const JointEquations& joint, Side side, const ConstraintRow& row, Eigen::Ref<VecX> column);

}  // namespace concord::cartesian
