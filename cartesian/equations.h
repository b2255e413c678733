#pragma once

#include <memory>
#include <optional>
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
class Equations {  // (C40)
 public:
  explicit Equations(const Model& model);

  [[nodiscard]] const Model& model() const { return model_; }
  [[nodiscard]] const Layout& layout() const { return layout_; }
  [[nodiscard]] const Constraints& constraints() const { return constraints_; }
  [[nodiscard]] Constraints& constraints() { return constraints_; }
  [[nodiscard]] const AppliedForces& applied() const { return applied_; }
  [[nodiscard]] AppliedForces& applied() { return applied_; }
  [[nodiscard]] const BodyInertia& inertia(int body) const { return inertias_[body]; }

  /// Which constraint rows take part (all of them until this is called). The pattern holds all rows: those that take no
  /// part are rows of the identity.
  void use_rows(const std::vector<bool>& active);
  [[nodiscard]] bool is_active(int row) const { return active_[row]; }
  [[nodiscard]] const std::vector<bool>& active_rows() const { return active_; }

  /// Joint coordinates (by joint) from which the turns of sprung and coupled angles are counted: at most half a turn
  /// away.
  void count_turns_from(const std::vector<VecX>& q);

  /// Everything that follows from positions and velocities; t in s.
  void update(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);

  /// Accelerations and multipliers at the updated state. With `fresh_pivots` the factorization chooses its pivots anew
  /// and the solution is refined to round-off. Throws SolverError where the matrix is singular (C40).
  void solve(bool fresh_pivots);
  [[nodiscard]] const VecX& Ydot() const { return Ydot_; }
  /// A constraint row that takes no part because it depends on others, and whose accelerations those others contradict:
  /// the worst of those that miss by more than kContradiction of the machine's accelerations, if any. After solve().
  [[nodiscard]] std::optional<int> contradicted_row();
  /// One multiplier for each constraint row; zero for rows that take no part.
  [[nodiscard]] const VecX& lambda() const { return lambda_; }

  [[nodiscard]] double time() const { return t_; }
  /// Phi and Phi_Y Y + Phi_t at the updated state, all rows.
  [[nodiscard]] const VecX& residual() const { return residual_; }
  [[nodiscard]] const VecX& velocity_residual() const { return velocity_residual_; }

  /// The machine's units over Y, one for each number: v by the machine's length L, omega by 1, adot by the size that
  /// moves a joint by L. All that is called small or large is so in these units.
  [[nodiscard]] const VecX& units() const { return units_; }
  /// Norm of each constraint row over Y in the machine's units at the updated state: what its residual is measured by;
  /// a coupling's is the sum of its terms' norms, so that one whose terms cancel is seen to be small. Zero for a row
  /// that vanishes.
  [[nodiscard]] const VecX& row_sizes() const {
    if (!has_row_sizes_) measure_rows();
    return row_sizes_;
  }
  /// How often a residual holds its round-off, by row: 1, or of rows that read places the distance from the origin in
  /// lengths of the machine, or the row's own terms (many turns) by its size.
  void measure_terms(double t, const Eigen::Ref<const VecX>& q);
  [[nodiscard]] const VecX& terms() const { return terms_; }
  /// The farthest that anything stands from the origin or its body's origin, in lengths of the machine; at least 1.
  [[nodiscard]] double reach() const { return reach_; }
  /// How much less a step of positions moves a mode than a coordinate without stiffness, at most 1.
  [[nodiscard]] double compliance(int body, int mode) const;
  /// The largest residual by row sizes and terms, a number without a unit; for velocities [1/s] (C45).
  [[nodiscard]] double largest_residual(const VecX& residual) const;
  [[nodiscard]] double largest_velocity_residual(const VecX& velocity_residual) const;
  /// The same; rows that read places by the distance from the origin besides: round-off of places stands between the
  /// points of a joint and turns with them. After measure_terms().
  [[nodiscard]] double largest_velocity_residual_by_reach(const VecX& velocity_residual) const;
  /// The largest speed in the machine's units at the updated state [1/s], that of laws of drivers included; at least a
  /// millionth of the rate that the forces would bring about over the machine's length.
  [[nodiscard]] double largest_rate(double t, const Eigen::Ref<const VecX>& Y) const;
  /// That rate [1/s]: sqrt(acceleration / L), the largest of all bodies (C46).
  [[nodiscard]] double natural_rate() const;

  /// The joint or coupling that a row belongs to, "joint 'A'", and that of the largest of these rows by their sizes.
  [[nodiscard]] std::string name_of(int row) const;
  [[nodiscard]] std::string name_of_largest(const VecX& residual) const;

  /// Brings q and Y onto the constraints with the factors of the last solve(): velocities nearest in the sense of the
  /// mass matrix, positions too but for modes, which are moved as little as their stiffness asks; rows that hold for
  /// velocities alone do not restrict positions. Newton's method until the residuals stop falling. Throws SolverError
  /// if they stay above 1e-9 in the machine's units.
  void project(double t, Eigen::Ref<VecX> q, Eigen::Ref<VecX> Y);

  /// Power of drivers, joint springs and force elements less that of modal damping [W] at the updated state; with the
  /// multipliers of the last solve(), or with others (one for each row).
  [[nodiscard]] double power() const { return power_of(lambda_); }
  [[nodiscard]] double power_of(const Eigen::Ref<const VecX>& lambda) const;  // (C39)

  /// The matrix with the numbers of the last solve() or fill_matrix(), rows that take no part included.
  [[nodiscard]] const SparseLu& matrix() const { return *matrix_; }
  /// Its numbers at the updated state.
  void fill_matrix();
  /// Column of a constraint row in the matrix.
  [[nodiscard]] int index_of(int row) const { return layout_.n_Y() + row; }
  /// Unit of inertia that the matrix is scaled with, a power of two near the mass of all bodies [kg].
  [[nodiscard]] double mass_unit() const { return mass_unit_; }

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
  [[nodiscard]] bool magnifies_round_off() const;
  [[nodiscard]] double typical_acceleration(const Eigen::Ref<const VecX>& Ydot) const;
  void lay_out();
  void measure_rows() const;
  void find_entries();
  void stiffen_modes();
  void factor_position_matrix();
  void project_positions(double t, Eigen::Ref<VecX> q);
  void project_velocities(double t, Eigen::Ref<VecX> Y);
  void solve_constraint_step(SparseLu& matrix, const VecX& residual);

  const Model& model_;
  double length_;  // the machine's [m]
  Layout layout_;
  std::vector<BodyInertia> inertias_;
  Constraints constraints_;
  AppliedForces applied_;
  std::vector<MatX> mass_matrices_;  // by body
  std::vector<double> stiffening_;   // by body [s^2]: what stiffness counts for beside inertia in steps of positions
  std::vector<bool> active_;         // by constraint row
  double mass_unit_ = 1.0;
  bool has_new_rows_ = true;           // since the last factorization
  bool has_new_position_rows_ = true;  // the same of the position matrix
  bool magnifies_ = false;  // the condition magnifies round-off beyond what evaluations between steps may lose
  std::unique_ptr<SparseLu> matrix_;
  /// The matrix that steps of positions are taken with: no rows that hold for velocities alone, and modes held by their
  /// stiffness, so that they take no round-off of the joints. nullptr: it is the matrix itself.
  std::unique_ptr<SparseLu> position_matrix_;
  /// Where blocks go in the matrix's values: by body the first entry of each column of M; by block of rows and column
  /// of the body the first of the block's rows; by block and row the first of the body's entries in the row's column.
  std::vector<std::vector<int>> mass_entries_;
  std::vector<std::vector<int>> Phi_Y_entries_;
  std::vector<std::vector<int>> transposed_entries_;

  double t_ = 0.0;
  VecX Y_;
  VecX forces_;
  VecX gamma_;
  VecX residual_;
  VecX velocity_residual_;
  VecX units_;
  mutable VecX row_sizes_;  // computed when they are asked for
  mutable bool has_row_sizes_ = false;
  VecX terms_;  // by row
  VecX reaches_;
  double reach_ = 1.0;
  VecX Ydot_;
  VecX lambda_;
  VecX unknowns_;
  VecX step_;
};

}  // namespace concord::cartesian
