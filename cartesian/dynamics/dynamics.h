#pragma once

#include <optional>
#include <vector>

#include "cartesian/dynamics/augmented_matrix.h"
#include "cartesian/dynamics/equations.h"
#include "cartesian/dynamics/inertia_elimination.h"
#include "cartesian/dynamics/projection.h"

namespace concord::cartesian {

/// Accelerations and multipliers in the state of the last update. Only Dynamics makes one: who holds it knows that the
/// equations are solved and their matrix is factorized. Overwritten by the next solution.
class Solution {
 public:
  Solution(const Solution&) = delete;
  Solution& operator=(const Solution&) = delete;

  [[nodiscard]] const VecX& Ydot() const { return Ydot_; }
  /// One multiplier for each constraint row; zero for rows that take no part.
  [[nodiscard]] const VecX& lambda() const { return lambda_; }

 private:
  friend class Dynamics;
  Solution(int n_Y, int n_rows) : Ydot_(VecX::Zero(n_Y)), lambda_(VecX::Zero(n_rows)) {}

  VecX Ydot_;
  VecX lambda_;
};

/// Pivots chosen anew unless the last ones are as good, with a solution refined to round-off; or those of the last
/// factorization.
enum class Pivots { fresh, kept };

/// Solves the equations of motion of the whole machine,
///   [M  Phi_Y^T; Phi_Y  0] [Ydot; lambda] = [Q - S - U; gamma],
/// over all bodies and an independent set of constraint rows. Memory is laid out once; a solution allocates nothing.
class Dynamics {  // (C40)
 public:
  /// The equations must outlive this object.
  explicit Dynamics(Equations& equations);
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  [[nodiscard]] const Equations& equations() const { return equations_; }
  [[nodiscard]] Equations& equations() { return equations_; }

  /// Which constraint rows take part (all of them until this is called).
  void use_rows(const std::vector<bool>& active);
  [[nodiscard]] bool is_active(RowIndex row) const { return active_[row.value]; }
  [[nodiscard]] const std::vector<bool>& active_rows() const { return active_; }
  /// Adds Phi_Y^T x over the active rows to `sum` (n_Y rows), x one number for each constraint row.
  void add_Phi_Y_transposed_times(const Eigen::Ref<const VecX>& x, Eigen::Ref<VecX> sum) const;

  /// The matrix with its numbers at the last update of the equations, rows that take no part included.
  const SparseLu& fill_matrix();

  /// Accelerations and multipliers at the last update of the equations. Throws SingularPose where the matrix is
  /// singular (C40).
  const Solution& solve(Pivots pivots);
  /// Updates the equations first.
  const Solution& solve_at(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y, Pivots pivots);

  /// So many states near which solutions are kept with their factors.
  void keep_places(int n);
  /// As solve_at with kept pivots, at one of these places; `again`: next to the last state there, so that its factors
  /// tell what has changed since.
  const Solution& solve_at_place(int place, bool again, double t, const Eigen::Ref<const VecX>& q,
                                 const Eigen::Ref<const VecX>& Y);

  /// Accelerations that generalized forces (n_Y rows) cause by themselves at the last solution, as joints let them.
  void accelerate(const Eigen::Ref<const VecX>& forces, Eigen::Ref<VecX> accelerations);
  /// Whether the inertias are eliminated between steps, as was found good where this was last looked at.
  [[nodiscard]] bool eliminates_inertias() const { return eliminates_; }

  /// A constraint row that takes no part because it depends on others, and whose accelerations those others contradict:
  /// the worst of those that miss by more than kContradiction of the machine's accelerations, if any.
  [[nodiscard]] std::optional<RowIndex> contradicted_row(const Solution& solution);

  /// Brings q and Y onto the constraints (Projection::project) with the factors of a solution nearby.
  const RoundOffShares& project(const Solution& nearby, double t, Eigen::Ref<VecX> q, Eigen::Ref<VecX> Y);
  [[nodiscard]] double velocity_residual_left() const { return projection_.velocity_residual_left(); }

 private:
  /// A solution by elimination, with factors of its own.
  struct Place {
    InertiaElimination elimination;
    VecX unknowns;
    bool is_known = false;
  };

  void write_right_side();
  const Solution& solve(Pivots pivots, const Place* near);
  [[nodiscard]] bool factor_and_solve(Pivots pivots, const Place* near);
  [[nodiscard]] bool solve_by_elimination();
  [[nodiscard]] bool solve_by_factors_of(const Place& near);
  [[nodiscard]] bool solve_by_whole_matrix();
  [[nodiscard]] bool solve_with_last_pivots();
  void measure_least_unknowns();
  [[nodiscard]] bool is_good_elimination();
  void judge_elimination();
  [[nodiscard]] bool loses_more_than(double part, double relative_error, const VecX& error) const;

  Equations& equations_;
  AugmentedMatrix matrix_;
  std::vector<Place> places_;        // the first for solutions anywhere
  InertiaElimination* elimination_;  // of the last solution
  Projection projection_;
  std::vector<bool> active_;    // by constraint row
  bool has_new_rows_ = true;    // since the last factorization that served
  bool eliminates_ = false;     // inertias are eliminated between steps
  bool is_eliminated_ = false;  // in the state of the last solution
  /// What it takes that round-off, magnified by the condition, does not cost more than evaluations between steps may
  /// lose: a residual in double precision, or as if in twice that.
  enum class Refinement { none, rough, exact } refinement_ = Refinement::none;
  double judged_at_ = 0.0;  // magnified round-off where the elimination was judged
  VecX gamma_;
  VecX right_side_;
  VecX unknowns_;
  VecX trial_;           // by elimination, where the solution is known
  VecX error_;           // of that
  VecX least_unknowns_;  // accelerations that are none, by the equations' residuals; zero for multipliers
  Solution solution_;
};

}  // namespace concord::cartesian
