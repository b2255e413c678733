#pragma once

#include <optional>

#include "relative/bodies/motion.h"
#include "relative/dynamics/equations.h"

/// Between complete states (poses and velocities of all bodies) and the solver's own coordinates.
namespace concord::relative {

/// How far a state is from one that this solver could have made.
struct StateMisfit {
  /// Largest misfit over joints, drivers, couplings and Euler parameter norms, free of units: displacements relative to
  /// the larger of the machine's length and the largest |r|, rotations in rad; velocities the same, per unit of the
  /// larger of the machine's rate and the state's largest speed, MachineSize::rate_at.
  double largest = 0.0;
  /// Where: "joint 'B'", "body 'crank'" or "coupling 'G'".
  std::string where;
  /// A joint whose coordinates, as measured between its bodies, lie on another turn or branch than those that came with
  /// the state; if there is one.
  std::optional<JointIndex> joint_off_branch;

  /// Keeps the larger misfit; one that is not a number is the largest.
  void take(double value, const char* kind, const std::string& name);
};

class States {
 public:
  /// The equations must outlive this object.
  explicit States(const Equations& equations);

  /// Throws SolverError if the state has the wrong size.
  void require_shape(const State& state) const;

  /// Coordinates of a state: those of every joint are measured between its two bodies, tree and cut joints alike, from
  /// the state's q, which chooses turns and branches (without them, the branch nearest to home); cost proportional to
  /// the number of joints. `misfit` gets what the joints do not permit, and how far driven coordinates are from their
  /// laws. Whole turns beyond the first are counted apart, see turns(). Throws SolverError if the state has the wrong
  /// size or its bodies hold an entry that is not a number.
  Coordinates read(const State& state, StateMisfit& misfit);

  /// The same of a state that was displaced from one whose coordinates it brings, and that is open in second order:
  /// joints stay on the branches on which they were, and what is left open is no misfit.
  Coordinates read_beside(const State& state);

  /// The same of a closed state; throws SolverError where something does not close to round-off, or stands on another
  /// branch than q says.
  Coordinates read_closed(const State& state);

  /// The whole turns that the coordinates of the last state leave out: see Kinematics::count_turns.
  [[nodiscard]] const VecX& turns() const { return kinematics_.turns(); }

  /// The complete state of the equations' motion; Euler parameters of the sign nearest to those of `before` (if it is
  /// not empty).
  [[nodiscard]] State write(const Motion& motion, const State& before) const;

  /// A joint whose coordinates in q, turns counted as when a state was read last, lie on another turn or branch than
  /// those that the state brings; if there is one.
  [[nodiscard]] std::optional<JointIndex> joint_off_branch(const State& state, const VecX& q) const;

  /// Accelerations alone.
  [[nodiscard]] Evaluation write_accelerations(const Evaluated& evaluated) const;
  /// Accelerations and wrenches.
  [[nodiscard]] Evaluation write_evaluation(const Evaluated& evaluated, const JointReactions& reactions) const;

 private:
  /// What the misfits of a state are relative to.
  struct Sizes {
    double place;  // [m]
    double rate;   // [1/s]
  };
  [[nodiscard]] Coordinates stated_coordinates(const State& state) const;
  [[nodiscard]] Coordinates measure_joints(const State& state, JointMeasure::Restart restart);
  void measure_joint(JointIndex k, JointMeasure::Restart restart, Coordinates& found);
  void take_misfit(JointIndex k, const Sizes& sizes, const Coordinates& found, StateMisfit& misfit);
  void measure_coupling(const Coupling& coupling, const Sizes& sizes, const Coordinates& found,
                        StateMisfit& misfit) const;
  [[nodiscard]] double nonholonomic_residual(JointIndex joint, const VecX& u);
  [[nodiscard]] double angle_size(const Span& span) const;
  struct Readings {
    double of_coordinates = 0.0;
    double of_speeds = 0.0;
  };
  [[nodiscard]] Readings size_of_readings(const Coupling& coupling) const;
  [[noreturn]] void throw_off_branch(const State& state, const Coordinates& coordinates, JointIndex joint) const;
  void count_turns(Coordinates& coordinates);
  [[nodiscard]] bool has_q(const State& state, JointIndex joint) const;

  const Equations* equations_;
  Kinematics kinematics_;
  std::vector<JointMeasure> measures_;
  std::vector<NonholonomicConstraint> nonholonomic_;
};

}  // namespace concord::relative
