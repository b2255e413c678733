#pragma once

#include "relative/rank/closure_rank.h"
#include "relative/rank/scaled_closure.h"
#include "relative/start/projection.h"
#include "relative/start/start.h"

/// Closing a machine: at the start from the model's values, near a guess, and after each step of an integration.
namespace concord::relative {

class Assembly {
 public:
  /// The equations must outlive this object.
  explicit Assembly(Equations& equations);
  Assembly(const Assembly&) = delete;
  Assembly& operator=(const Assembly&) = delete;

  [[nodiscard]] const ScaledClosure& scaled() const { return scaled_; }

  /// Start::find, and the choice of rows if there was none before. Throws as Start::find.
  [[nodiscard]] Coordinates start();
  /// Whether it was found from other values than the model's guesses.
  [[nodiscard]] bool has_searched_for_its_start() const { return start_.has_searched(); }

  /// Closes q and u near their values at time t, couplings and nonholonomic constraints too. Modal coordinates and
  /// rates are kept, unless the loops restrict them, as where a flexible body is held at both ends: then they move by
  /// the shortest steps too. False if Newton's method fails.
  [[nodiscard]] bool close(Coordinates& coordinates);

  /// Projects a state that is closed but for the error of one integration step: Projection::project.
  void project(Coordinates& coordinates) { projection_.project(coordinates, closure_rank_.closing_modes()); }
  /// Closes positions near the given ones; false where the loops will not close.
  [[nodiscard]] bool close_positions_nearby(Coordinates& coordinates) {
    return projection_.try_positions(coordinates, closure_rank_.closing_modes());
  }

  /// Decides how many closure rows are independent in a general pose near the start (near `coordinates`, if the machine
  /// has no start), and what closing has to move; once.
  void decide_rank(const Coordinates& coordinates);
  [[nodiscard]] const ClosureRank& closure_rank() const { return closure_rank_; }

  /// Largest misfit of position and velocity closure in machine units, as the projection measures it: position residual
  /// / max(1, largest coordinate), velocity residual relative to the largest speed.
  [[nodiscard]] double misfit(const Coordinates& coordinates);

 private:
  [[nodiscard]] bool close_at_rank(Coordinates& coordinates, Modes modes) const;

  ScaledClosure scaled_;
  Start start_;
  Projection projection_;
  ClosureRank closure_rank_;
};

}  // namespace concord::relative
