#pragma once

#include <memory>
#include <vector>

#include "cartesian/applied_forces.h"
#include "cartesian/body_inertia.h"
#include "cartesian/constraints.h"
#include "cartesian/layout.h"
#include "cartesian/sparse_lu.h"
#include "common/model.h"

namespace concord::cartesian {

/// Equations of motion of the whole machine,
///   [M  Phi_Y^T; Phi_Y  0] [Ydot; lambda] = [Q - S - U; gamma],
/// over all bodies and an independent set of constraint rows. Memory is laid out once; an evaluation allocates nothing.
class Equations {
 public:
  explicit Equations(const Model& model);

  [[nodiscard]] const Model& model() const { return model_; }
  [[nodiscard]] const Layout& layout() const { return layout_; }
  [[nodiscard]] const Constraints& constraints() const { return constraints_; }
  [[nodiscard]] Constraints& constraints() { return constraints_; }
  [[nodiscard]] const AppliedForces& applied() const { return applied_; }
  [[nodiscard]] AppliedForces& applied() { return applied_; }
  [[nodiscard]] const BodyInertia& inertia(int body) const { return inertias_[body]; }

  /// Which constraint rows take part (all of them until this is called); freezes the pattern anew.
  void use_rows(const std::vector<bool>& active);
  [[nodiscard]] bool is_active(int row) const { return place_of_row_[row] >= 0; }

  /// Joint coordinates (by joint) from which the turns of sprung and coupled angles are counted: at most half a turn
  /// away.
  void count_turns_from(const std::vector<VecX>& q);

  /// Everything that follows from positions and velocities; t in s.
  void update(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);

  /// Accelerations and multipliers at the updated state. With `fresh_pivots` the factorization chooses its pivots anew.
  /// Throws SolverError where the matrix is singular.
  void solve(bool fresh_pivots);
  [[nodiscard]] const VecX& Ydot() const { return Ydot_; }
  /// One multiplier for each constraint row; zero for rows that take no part.
  [[nodiscard]] const VecX& lambda() const { return lambda_; }

  /// Phi and Phi_Y Y + Phi_t at the updated state, all rows.
  [[nodiscard]] const VecX& residual() const { return residual_; }
  [[nodiscard]] const VecX& velocity_residual() const { return velocity_residual_; }

  /// The joint or coupling that has the largest of these rows: "joint 'A'".
  [[nodiscard]] std::string name_of_largest(const VecX& residual) const;

  /// Brings q and Y onto the constraints, nearest in the sense of the mass matrix, with the factors of the last
  /// solve(); rows that hold for velocities alone do not restrict positions. Newton's method until the residuals stop
  /// falling. Throws SolverError if they stay above 1e-9.
  void project(double t, Eigen::Ref<VecX> q, Eigen::Ref<VecX> Y);

  /// Power of drivers, joint springs and force elements less that of modal damping [W] at the updated state; with the
  /// multipliers of the last solve(), or with others (one for each row).
  [[nodiscard]] double power() const { return power_of(lambda_); }
  [[nodiscard]] double power_of(const Eigen::Ref<const VecX>& lambda) const;

  /// The matrix with the numbers of the last solve(), for whoever looks into it, such as a benchmark.
  [[nodiscard]] const SparseLu& matrix() const { return *matrix_; }

  /// Generalized forces Q - S - U, n_Y rows; Q holds gravity, force elements and joint springs.
  [[nodiscard]] const VecX& forces() const { return forces_; }
  /// Adds Phi_Y^T x over the active rows to `sum` (n_Y rows), x one number for each constraint row.
  void add_Phi_Y_transposed_times(const Eigen::Ref<const VecX>& x, Eigen::Ref<VecX> sum) const;
  /// Mass matrices of all bodies at the updated state; part of solve().
  void fill_mass_matrices();
  [[nodiscard]] const MatX& mass_matrix(int body) const { return mass_matrices_[body]; }
  /// M x, n_Y rows; after fill_mass_matrices().
  void write_mass_times(const Eigen::Ref<const VecX>& x, Eigen::Ref<VecX> product) const;

 private:
  void lay_out();
  void fill_matrix();
  void factor_position_matrix();
  void solve_constraint_step(SparseLu& matrix, const VecX& residual);

  const Model& model_;
  Layout layout_;
  std::vector<BodyInertia> inertias_;
  Constraints constraints_;
  AppliedForces applied_;
  std::vector<MatX> mass_matrices_;  // by body
  std::vector<int> place_of_row_;    // column of an active row in the matrix; -1
  std::vector<bool> is_slip_place_;  // by column of the matrix: a row that holds for velocities alone
  std::unique_ptr<SparseLu> matrix_;
  /// The matrix with unit rows for what holds for velocities alone; nullptr: there is no such row.
  std::unique_ptr<SparseLu> position_matrix_;
  /// Where blocks go in the matrix's values: by body the first entry of each column of M; by block of rows and column
  /// of the body the first of the block's rows; by block and row the first of the body's entries in the row's column
  /// (-1: the row takes no part).
  std::vector<std::vector<int>> mass_entries_;
  std::vector<std::vector<int>> Phi_Y_entries_;
  std::vector<std::vector<int>> transposed_entries_;

  double t_ = 0.0;
  VecX Y_;
  VecX forces_;
  VecX gamma_;
  VecX residual_;
  VecX velocity_residual_;
  VecX Ydot_;
  VecX lambda_;
  VecX unknowns_;
  VecX step_;
};

}  // namespace concord::cartesian
