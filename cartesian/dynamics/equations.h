#pragma once

#include <memory>
#include <vector>

#include "cartesian/bodies/body_inertia.h"
#include "cartesian/bodies/constraints.h"
#include "cartesian/bodies/indices.h"
#include "cartesian/bodies/layout.h"
#include "cartesian/bodies/machine_scales.h"
#include "cartesian/forces/applied_forces.h"
#include "common/model.h"

namespace concord::cartesian {

/// Both sides of the machine's equations at one state, the first phase of all that is computed: constraint rows with
/// their residuals, inertias and generalized forces. Who solves them (Dynamics), decides their rank or closes them
/// reads them from here. Memory is laid out once; an update allocates nothing.
class Equations {
 public:
  explicit Equations(const Model& model);
  Equations(const Equations&) = delete;
  Equations& operator=(const Equations&) = delete;

  [[nodiscard]] const Model& model() const { return model_; }
  [[nodiscard]] const Layout& layout() const { return layout_; }
  /// What holds of the constraints in every state.
  [[nodiscard]] const Constraints& constraints() const { return *constraints_; }
  [[nodiscard]] const AppliedForces& applied() const { return applied_; }
  [[nodiscard]] AppliedForces& applied() { return applied_; }
  [[nodiscard]] const BodyInertia& inertia(BodyIndex body) const { return inertias_[body]; }
  [[nodiscard]] const MachineScales& scales() const { return scales_; }
  /// The machine's units over Y, and its length [m].
  [[nodiscard]] const VecX& units() const { return scales_.units; }
  [[nodiscard]] double length() const { return scales_.length; }

  /// Joint coordinates (by joint) from which the turns of sprung and coupled angles are counted: at most half a turn
  /// away.
  void count_turns_from(const std::vector<VecX>& q);
  /// The same, and the angles from which the turns of turn springs are counted.
  void count_turns_from(const State& state);
  /// Counts them from where another copy of the same equations does, and holds the regimes of tires and stops as that
  /// does.
  void count_turns_and_hold_regimes_as(const Equations& other);

  /// Everything that follows from positions and velocities; t in s.
  void update(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);

  // At the last update, which there must have been:
  [[nodiscard]] const MovingConstraints& moving_constraints() const { return *moving_; }
  [[nodiscard]] MovingConstraints& moving_constraints() { return *moving_; }
  [[nodiscard]] double time() const { return t_; }
  [[nodiscard]] const VecX& Y() const { return Y_; }
  /// Phi and Phi_Y Y + Phi_t, all rows.
  [[nodiscard]] const VecX& residual() const {
    if (!has_residuals_) compute_residuals();
    return residual_;
  }
  [[nodiscard]] const VecX& velocity_residual() const {
    if (!has_residuals_) compute_residuals();
    return velocity_residual_;
  }
  /// Norm of each constraint row over Y in the machine's units: what its residual is measured by; a coupling's is the
  /// sum of its terms' norms, so that one whose terms cancel is seen to be small. Zero for a row that vanishes.
  [[nodiscard]] const VecX& row_sizes() const {
    if (!has_row_sizes_) measure_rows();
    return row_sizes_;
  }
  /// Generalized forces Q - S - U, n_Y rows; Q holds gravity, force elements and joint springs.
  [[nodiscard]] const VecX& forces() const { return forces_; }
  /// Writes the mass matrices of all moving bodies (make_mass_matrices).
  void write_mass_matrices(ByBody<MatX>& M) const;
  /// The first six rows of a body's, those of v and omega.
  template <class Block>
  void write_rigid_rows(BodyIndex body, Block&& M) const {
    deformed_[body].write_rigid_rows(moving_->rotation(body), M);
  }
  /// Power of drivers, joint springs and force elements less that of modal damping [W], with these multipliers (one for
  /// each row).
  [[nodiscard]] double power_of(const Eigen::Ref<const VecX>& lambda) const;  // (C39)

 private:
  void update_at(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);
  void compute_residuals() const;
  void measure_rows() const;
  [[nodiscard]] double size_of(JointIndex joint, int own) const;

  const Model& model_;
  Layout layout_;
  ByBody<BodyInertia> inertias_;
  MachineScales scales_;
  ByBody<DeformedInertia> deformed_;
  std::unique_ptr<Constraints> constraints_;
  AppliedForces applied_;

  MovingConstraints* moving_ = nullptr;
  double t_ = 0.0;
  VecX Y_;
  VecX forces_;
  // Computed when they are asked for:
  mutable VecX residual_;
  mutable VecX velocity_residual_;
  mutable VecX row_sizes_;
  mutable bool has_residuals_ = false;
  mutable bool has_row_sizes_ = false;
};

/// The modal masses of all bodies.
ByBody<MatX> modal_masses(const Equations& equations);
/// Room for the mass matrices of all bodies; ground's is empty.
ByBody<MatX> make_mass_matrices(const Layout& layout);
/// M x, n_Y rows.
void write_mass_times(const Layout& layout, const ByBody<MatX>& M, const Eigen::Ref<const VecX>& x,
                      Eigen::Ref<VecX> product);

}  // namespace concord::cartesian
