#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "common/types.h"

namespace concord::cartesian {

/// Square sparse matrix of a frozen pattern (compressed columns, rows ascending) and its LU factors by KLU: symbolic
/// analysis once, numbers as often as they change. Structural zeros stay in the pattern. What is factorized is the
/// matrix with rows and columns scaled by powers of two to entries of about one, so that nothing depends on units.
class SparseLu {
 public:
  /// A symmetric pattern is ordered as it stands; any other first to block triangular form, which would spoil symmetry
  /// and with it sparse factors.
  enum class Pattern { general, symmetric };

  SparseLu(std::vector<int> column_starts, std::vector<int> row_indices, Pattern pattern = Pattern::general);
  ~SparseLu();
  SparseLu(const SparseLu&) = delete;
  SparseLu& operator=(const SparseLu&) = delete;

  [[nodiscard]] int size() const { return static_cast<int>(column_starts_.size()) - 1; }
  [[nodiscard]] double* values() { return values_.data(); }
  [[nodiscard]] const double* values() const { return values_.data(); }
  [[nodiscard]] const std::vector<int>& column_starts() const { return column_starts_; }
  [[nodiscard]] const std::vector<int>& row_indices() const { return row_indices_; }
  /// Place of entry (row, column) in values(); the entry must be in the pattern.
  [[nodiscard]] int find(int row, int column) const;

  /// Rows and columns that count as those of the identity, whatever values() hold; they need their diagonal entries in
  /// the pattern. Factorize with new pivots afterwards.
  void set_idle(const std::vector<bool>& idle) { idle_ = idle; }
  /// Unit of the diagonal (a power of two) that a symmetric matrix is scaled with.
  void set_diagonal_unit(double unit) { diagonal_unit_ = unit; }
  /// By column: what a symmetric matrix is scaled as if it had on its diagonal where it has less; 0: the column has no
  /// diagonal entry of its own. An inertia that round-off alone keeps from zero is no scale.
  [[nodiscard]] VecX& least_diagonal() { return least_diagonal_; }
  [[nodiscard]] const VecX& least_diagonal() const { return least_diagonal_; }

  /// Factorizes with new pivots. False if the matrix is singular.
  bool factor();
  /// Factorizes with the pivots and scales of the last factor(); falls back to factor() if they are no longer good.
  bool refactor();
  /// Solves in place.
  void solve(VecX& x);
  /// Solves in place and improves the solution from its residual, which is summed in twice the precision, until the
  /// corrections reach round-off or fall no more; not at all while the scaled residual, summed in double precision, is
  /// at most `good_enough` of the scaled right side. False if the corrections do not fall: the matrix is singular for
  /// double precision, or the pivots have gone bad.
  bool solve_refined(VecX& x, double good_enough);
  /// The same, but each equation is held by itself: its residual is good enough as a part of the sizes of its terms. In
  /// these no unknown counts as less than its entry of `least` (zero: any is as small as it is). So the small terms of
  /// a light body's equations count as much as those of its heavy neighbours, which they lead.
  bool solve_equation_by_equation(VecX& x, double good_enough, const VecX& least);
  /// Improves x, a solution of the matrix as its values are, from residuals in twice the precision, with what solves it
  /// nearly in place of the factors. False if the corrections do not fall to where the next would be round-off.
  bool improve(const VecX& right_side, VecX& x, const std::function<void(VecX&)>& solve_nearly);
  /// The first correction of the last solution, a measure of how the condition magnifies round-off; zeros if
  /// there was none.
  [[nodiscard]] const VecX& first_correction() const { return first_correction_; }
  /// Its size relative to the solution, both scaled.
  [[nodiscard]] double relative_correction() const { return relative_correction_; }
  /// Size of x relative to y, both scaled.
  [[nodiscard]] double relative_size(const VecX& x, const VecX& y) const;
  /// y -= matrix x, idle rows and columns as they stand in values().
  void subtract_product(const VecX& x, VecX& y) const;

 private:
  void scale(bool anew);
  void choose_symmetric_scales();
  void choose_general_scales();
  [[nodiscard]] bool is_idle(int place) const { return !idle_.empty() && idle_[place]; }
  void begin_solving(const VecX& right_side);
  [[nodiscard]] bool end_solving(bool is_good, VecX& x) const;
  /// With what solves the scaled system in place, until a correction is no larger a part of the solution than `enough`.
  template <class SolveScaled>
  bool refine(double enough, const SolveScaled& solve_scaled);
  bool refine_by_factors();
  void solve_scaled(VecX& x);
  /// Of the scaled equations, in double precision or as if in twice that.
  void write_rough_residual();
  void write_exact_residual();
  /// Sums of the sizes of each scaled equation's terms, see solve_equation_by_equation().
  void write_terms(const VecX& least);

  std::vector<int> column_starts_;
  std::vector<int> row_indices_;
  std::vector<int> diagonal_;  // by column: index of the diagonal entry, -1: none
  std::vector<double> values_;
  std::vector<double> scaled_;
  std::vector<bool> idle_;
  double diagonal_unit_ = 1.0;
  VecX least_diagonal_;
  Pattern pattern_;
  VecX row_scales_;
  VecX column_scales_;
  struct KluHandles;
  std::unique_ptr<KluHandles> klu_;
  VecX right_side_;  // scaled
  VecX solution_;
  VecX residual_;
  VecX terms_;  // sums of their sizes, by equation
  std::vector<double> rounding_;
  VecX first_correction_;
  double relative_correction_ = 0.0;
  double last_correction_ = 0.0;  // relative too
};

}  // namespace concord::cartesian
