#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/audit/joint_motion.h"

/// How many of a machine's constraints are independent, and which forces hold each other? The third opinion's count,
/// from what joints permit in one state: no solver's Jacobian, multipliers or rank are used.
namespace concord::compare {

/// How the velocities that somebody calls permitted lie beside those that the joints permit.
struct SpanOfVelocities {
  /// All that is permitted is among them, and nothing else is.
  bool holds_all = true;
  bool holds_nothing_else = true;
  /// The joint, driver or coupling that is obeyed least, and by how much it is not, for velocities of unit size.
  std::string worst;
  double misfit = 0.0;
};

/// The constraints of a machine in one state: a column for each force that a joint, a driver or a coupling can exert on
/// the bodies, in units of the machine.
class MachineConstraints {
 public:
  /// The model must outlive it.
  MachineConstraints(const Model& model, const State& state);

  /// Rank, degrees of freedom and uniqueness, as a solver reports them.
  [[nodiscard]] const RankReport& report() const { return report_; }
  /// Whether rank and permitted directions are clear enough in this state for an opinion.
  [[nodiscard]] bool is_sure() const { return is_sure_; }
  /// Joints, drivers and couplings that hold each other in some self-stress: "joint A", "coupling mesh".
  [[nodiscard]] const std::vector<std::string>& in_self_stress() const { return in_self_stress_; }

  /// Orthonormal columns: multipliers that hold each other, and exert nothing together.
  [[nodiscard]] const MatX& self_stresses() const { return self_stresses_; }
  /// The largest that self-stresses of unit size move of any wrench, forces times the machine's length, and how far
  /// they move what is unique at most.
  [[nodiscard]] double largest_moved() const { return largest_moved_; }
  [[nodiscard]] double unmoved() const;
  /// What each multiplier adds to a joint's reaction on a side, in that side's joint frame: a column [F l; T] each.
  [[nodiscard]] Mat6X reactions_on(int joint, Side side) const;
  /// The directions in which the joint can move, [d / l; turn] in the parent's joint frame, and what self-stresses add
  /// to its reaction on the child there; both as columns.
  [[nodiscard]] Mat6X permitted_by(int joint) const;
  [[nodiscard]] Mat6X stresses_of(int joint) const;
  /// The child's frame of a joint seen from the parent's.
  [[nodiscard]] const RelativeMotion& placement_of(int joint) const { return joints_[joint].relative; }

  /// `velocities`: columns as Solver::tangent() gives them.
  [[nodiscard]] SpanOfVelocities hold_against(const MatX& velocities) const;

  /// What independent self-stresses exert, one each, on both sides of the joints, on their speeds and by couplings
  /// [N, N m]: forces that leave every body of the machine as it is. Every reaction that fits a motion differs from
  /// every other by a sum of multiples of them. None where the machine has none, or is_sure() is false.
  [[nodiscard]] std::vector<Evaluation> self_stresses(const State& state) const;

 private:
  /// What the multipliers do at one joint, a column for each, forces times the machine's length; on the child at P_i,
  /// in the parent's joint frame.
  struct AtJoint {
    RelativeMotion relative;
    Mat6X reaction;
    Mat6X coordinate;
    MatX tau;
    MatX driver;  // what of tau drivers exert
  };

  /// How far self-stresses of unit size move the components of a joint's wrenches, and tau.
  struct Moved {
    std::array<VecX, 2> reaction;
    std::array<VecX, 2> total;
    VecX tau;
    VecX driver;
  };

  void lay_out_velocities();
  void lay_out_owners(const State& state);
  void add_multipliers();
  void add_coordinate_force(int joint, int speed, double factor, Eigen::Index column);
  [[nodiscard]] Mat6X velocities_of(std::size_t joint, const State& state) const;
  void normalize();
  void decompose();
  void mark_unique();
  void name_self_stressed();
  [[nodiscard]] Moved moved_at(std::size_t joint) const;
  [[nodiscard]] MatX on_side(const AtJoint& at, Side side, const Mat6X& wrenches) const;

  const Model& model_;
  double length_;
  std::vector<Eigen::Index> first_;  // of each body's velocities
  VecX units_;                       // of all velocities but those of origins, which count in lengths
  std::vector<JointMotion> motions_;
  std::vector<AtJoint> joints_;
  std::vector<std::string> owners_;  // of each column
  std::vector<Eigen::Index> couplings_;
  MatX forces_;     // on velocities, a column of unit size for each multiplier
  VecX sizes_;      // that the columns had
  MatX permitted_;  // velocities, orthonormal columns
  MatX self_stresses_;
  double largest_moved_ = 0.0;
  bool is_sure_ = true;
  RankReport report_;
  std::vector<std::string> in_self_stress_;
};

/// The joint or coupling whose places or velocities a state keeps least well, beyond what is a matter of round-off:
/// "joint cross"; empty if the state is closed.
std::string place_left_open(const Model& model, const State& state);

}  // namespace concord::compare
