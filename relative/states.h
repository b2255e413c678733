#pragma once

#include "relative/assembly.h"

/// Between complete states (poses and velocities of all bodies) and the solver's own coordinates.
namespace concord::relative {

/// How far a state is from one that this solver could have made.
struct StateMisfit {
  /// Largest misfit over joints, drivers, couplings and Euler parameter norms: positions [m, rad] relative to max(1,
  /// largest |r|), velocities relative to max(1, largest speed).
  double largest = 0.0;
  /// Where: "joint 'B'", "body 'crank'" or "coupling 'G'".
  std::string where;
};

class States {
 public:
  /// The equations must outlive this object.
  explicit States(const Equations& equations);

  /// Throws SolverError if the state has the wrong size.
  void require_shape(const State& state) const;

  /// Coordinates of a state: those of every joint are measured between its two bodies, tree and cut joints alike, with
  /// the state's q as first guess; cost proportional to the number of joints. `misfit` gets what the joints do not
  /// permit, and how far driven coordinates are from their laws. Throws SolverError if the state has the wrong size or
  /// its bodies hold what is no number.
  Coordinates read(const State& state, StateMisfit& misfit);

  /// The complete state of the pose that the equations hold; Euler parameters of the sign nearest to those of `before`
  /// (if it is not empty).
  [[nodiscard]] State write(double t, const State& before) const;

  /// Accelerations and wrenches that the equations hold.
  [[nodiscard]] Evaluation write_evaluation() const;

 private:
  [[nodiscard]] double slip_of(int joint, const VecX& u);

  const Equations* equations_;
  Kinematics kinematics_;
  double length_;
  std::vector<JointMeasure> measures_;
  std::vector<PermittedSpeeds> permitted_;
};

}  // namespace concord::relative
