#pragma once

#include <vector>

#include "relative/bodies/motion.h"
#include "relative/dynamics/equations.h"

/// The closure of a machine in its own units: what closing, projecting and the choice of rows are measured by.
namespace concord::relative {

/// Whether modal coordinates move where a machine is closed.
enum class Modes { kept, moving };
/// The closure rows that hold for positions, or all rows, which hold for velocities.
enum class ClosureRows { of_positions, of_velocities };

/// A machine is closed where its residuals are below this part of the largest coordinate or speed, at least of 1.
inline constexpr double kClosedPart = 1e-13;
/// Residuals and rows of the equations' closure in the units of the machine's size.
/// After Equations::move, unless a function says that it moves the machine itself.
class ScaledClosure {
 public:
  /// The equations must outlive this object.
  explicit ScaledClosure(Equations& equations);

  [[nodiscard]] Equations& equations() const { return *equations_; }
  [[nodiscard]] const Closure& closure() const { return equations_->closure(); }
  [[nodiscard]] const MachineSize& size() const { return equations_->size(); }

  /// Columns of the tree that are not prescribed, with or without those of modes.
  [[nodiscard]] std::vector<int> moving_columns(const PrescribedMask& prescribed, Modes modes) const;
  /// Those that no driver prescribes, modes included.
  [[nodiscard]] const std::vector<int>& free_columns() const { return free_columns_; }

  /// Moves the tree's coordinates by a finite step along the speeds (n_tree_u numbers, SI).
  void advance(VecX& q, const VecX& step) const;
  /// Moves the machine and completes the coordinates by what follows there.
  void move(Coordinates& coordinates) const;
  /// Makes Euler parameters of the coordinates unit.
  void normalize(VecX& q) const;

  /// Largest residual of positions, each as a part of what its row makes of the unit step of a coordinate, if that is
  /// more than 1: round-off of the coordinates leaves as much, as of a turn whose axis lies near another one.
  [[nodiscard]] double residual_of_coordinates(const Closure& measured, const std::vector<int>& columns) const;
  /// Largest residual of positions, and of velocities.
  [[nodiscard]] double position_residual() const;
  [[nodiscard]] double velocity_residual() const;
  /// Largest of 1, the largest coordinate, and what round-off of the places where the machine stands makes of
  /// kClosedPart far from the origin.
  [[nodiscard]] double size_of_places(const VecX& q) const;

  /// Phi_u over the given columns, rows and columns in the units of the machine (R63): of the equations' closure, or of
  /// one with other prescribed coordinates.
  [[nodiscard]] MatX rows(const std::vector<int>& columns) const { return rows(closure(), columns); }
  [[nodiscard]] MatX rows(const Closure& measured, const std::vector<int>& columns) const;
  /// Moves the machine there and takes the rank of its rows over the free columns, with or without modal ones.
  [[nodiscard]] int rank(const Coordinates& coordinates, ClosureRows rows, Modes modes) const;
  /// The same where the machine stands.
  [[nodiscard]] int rank_here(ClosureRows rows, Modes modes) const;
  /// The same of a closure with other prescribed coordinates, over the given columns.
  [[nodiscard]] int rank_here(const Closure& measured, ClosureRows rows, const std::vector<int>& columns) const;

 private:
  Equations* equations_;
  std::vector<int> free_columns_;
};

}  // namespace concord::relative
