#pragma once

#include <string>

#include "relative/rank/loop_rows.h"
#include "relative/rank/scaled_closure.h"

namespace concord::relative {

/// How many closure rows are independent in a general pose, which of them the loops use, and the poses in which fewer
/// are.
class ClosureRank {
 public:
  /// The closure must outlive this object.
  explicit ClosureRank(const ScaledClosure& scaled) : scaled_(&scaled), loop_rows_(scaled) {}

  [[nodiscard]] bool is_decided() const { return is_decided_; }
  /// Decides, near closed coordinates: the rank may be lower there, in a folded pose or with undeformed bodies, than it
  /// is in general: poses nearby, reached with the drivers released, decide.
  void decide_near(const Coordinates& closed);
  [[nodiscard]] int rank() const { return scaled_->equations().loops().rank(); }
  /// Whether modes must move to close the machine, because its loops restrict them; decided with the rank.
  [[nodiscard]] Modes closing_modes() const { return closing_modes_; }

  /// Of an evaluation in a closed pose: throws SingularPose, naming loop and time, if fewer closure rows are
  /// independent there than in a general pose.
  void require_general(const Coordinates& coordinates, const Evaluated& evaluated) const;
  /// Throws that; `passing` comes before "lose rank".
  [[noreturn]] void throw_singular(const Coordinates& coordinates, const std::string& passing) const;
  /// Throws SingularPose if closure rows that depend on others in this pose
  /// ask for other accelerations than those.
  void require_agreeing_rows(const Coordinates& coordinates, const Evaluated& evaluated) const;

  /// Size of the smallest singular value that a general pose has, of the closure rows where the machine stands: Phi, in
  /// machine units over the free columns.
  [[nodiscard]] double singular_value(const MatX& Phi) const;

 private:
  void decide_modes(const Coordinates& closed);

  const ScaledClosure* scaled_;
  mutable LoopRows loop_rows_;  // memory of singular_value()
  bool is_decided_ = false;
  Modes closing_modes_ = Modes::kept;
};

}  // namespace concord::relative
