#pragma once

#include <optional>
#include <vector>

#include "relative/dynamics/lambda_blocks.h"
#include "relative/rank/scaled_closure.h"

/// Closure rows without their zeros: a loop touches only what stands between its bodies.
namespace concord::relative {

/// The closure rows of a machine whose rows all belong to cut joints, over the free columns, or given ones, and in the
/// units of the machine, each multiplied by a weight of its column; and the factor of Phi Phi^T (R81). It serves where
/// the rows are clearly independent; RowRank judges where they are not.
class LoopRows {
 public:
  /// The closure must outlive this object.
  explicit LoopRows(const ScaledClosure& scaled) : LoopRows(scaled, scaled.closure(), scaled.free_columns()) {}
  /// Of a closure with other prescribed coordinates, which must outlive this object too, over these columns.
  LoopRows(const ScaledClosure& scaled, const Closure& closure, std::vector<int> columns);
  LoopRows(const LoopRows&) = delete;
  LoopRows& operator=(const LoopRows&) = delete;

  /// Factors the rows in the pose of the closure, for weights of the columns. False where they are not clearly
  /// independent, or where there are rows of other kinds.
  [[nodiscard]] bool factor(const VecX& weights);

  /// Factors Phi Phi^T + damping^2 of the rows that factor() has taken, independent or not, for the damped step (R65).
  /// False where round-off stands against it, or where there are rows of other kinds.
  [[nodiscard]] bool factor_damped(double damping);

  /// The smallest step x (one number per column) with Phi x = -misfit (one number per row).
  [[nodiscard]] VecX smallest_step(const VecX& misfit) const;
  /// The same, damped or not, where rows are so nearly dependent that their squares leave too few digits.
  [[nodiscard]] VecX refined_step(const VecX& misfit) const;

  /// Size of the smallest singular value, by inverse iteration as RowRank has it (R70).
  [[nodiscard]] double singular_value() const;
  /// Factors the rows, and tells the same as a part of the largest row, or of 1; nothing unless that is above all at
  /// which rows may count as dependent (kBesideSingular), so that RowRank must judge.
  [[nodiscard]] std::optional<double> find_clear_singular_value();

 private:
  /// Consecutive speeds of the tree that a loop moves: those of a joint, or of a body's modes.
  struct Columns {
    int first_u = 0;
    MatX rows;  // of the loop, over these speeds
  };
  struct Loop {
    CutIndex cut;
    std::optional<LinkIndex> common;  // the first link that the ways of both bodies to ground share; none: ground
    std::vector<Columns> columns;
  };
  /// What two loops, or one with itself, have in common; rows of the block by the first.
  struct Shared {
    int block;
    int loop, columns, other_loop, other_columns;
  };

  [[nodiscard]] std::vector<Loop> lay_out_loops() const;
  [[nodiscard]] EliminationOrder order_of_loops() const;
  void lay_out_shared();
  void compute(Loop& loop) const;
  void carry(BodyIndex body, MatX rows_on_body, Loop& loop) const;
  [[nodiscard]] MatX& rows_of(Loop& loop, int first_u) const;
  void sum_squares();
  void solve_squares(VecX& right) const;
  [[nodiscard]] VecX times_transpose(const VecX& y) const;
  [[nodiscard]] VecX times(const VecX& along) const;

  const ScaledClosure* scaled_;
  const Closure* closure_;
  std::vector<int> columns_;
  std::vector<Loop> loops_;
  LambdaBlocks squares_;  // Phi Phi^T
  BlockCholesky cholesky_;
  IndependentRows rows_;
  VecX diagonal_;
  std::vector<Shared> shared_;
  double damping_ = 0.0;
  VecX column_sizes_;  // of each speed of the tree: its unit times its weight, zero if it is prescribed
};

}  // namespace concord::relative
