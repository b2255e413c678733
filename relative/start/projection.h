#pragma once

#include "relative/rank/loop_rows.h"
#include "relative/rank/row_rank.h"
#include "relative/rank/scaled_closure.h"

namespace concord::relative {

/// Back to the constraints after each step of an integration: the smallest change in the units of the machine (R66).
class Projection {
 public:
  /// The closure must outlive this object.
  explicit Projection(const ScaledClosure& scaled);

  /// Round-off of a loop, put into a stiff mode, would be a force: with `Modes::kept` modes take next to no part where
  /// joints alone can close; near a pose in which these cannot, modes move. Throws SolverError, naming the joint and
  /// the residual, if the loops will not close.
  void project(Coordinates& coordinates, Modes modes);
  /// The positions alone, from a guess nearby; false where the loops will not close.
  [[nodiscard]] bool try_positions(Coordinates& coordinates, Modes modes);

 private:
  void factor_rows();
  [[nodiscard]] VecX step_against(const VecX& misfit) const;
  void project_positions(Coordinates& coordinates);
  void project_velocities(Coordinates& coordinates);
  [[nodiscard]] const VecX& weights() const { return modes_ == Modes::kept ? weights_of_joints_ : weights_of_all_; }

  const ScaledClosure* scaled_;
  Modes modes_ = Modes::moving;
  // By free column: as if it were this part of itself.
  VecX weights_of_joints_;
  VecX weights_of_all_;
  LoopRows loop_rows_;
  bool is_clear_ = false;  // whether loop_rows_ hold the factor
  RowRank row_factors_;
  RowRank position_factors_;  // of the rows for positions, where there are others
};

}  // namespace concord::relative
