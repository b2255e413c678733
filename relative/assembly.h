#pragma once

#include "relative/equations.h"
#include "relative/row_factors.h"
#include "relative/scales.h"

/// Closing a machine: at the start from the model's values, near a guess, and after each step of an integration.
namespace concord::relative {

/// Internal coordinates and speeds, in the order of Topology.
struct Coordinates {
  double t = 0.0;
  VecX q;
  VecX u;
};

class Assembly {
 public:
  /// The equations must outlive this object.
  explicit Assembly(Equations& equations);

  [[nodiscard]] const Scales& scales() const { return scales_; }

  /// After the accelerations have been computed: throws SingularPose if closure rows that depend on others in this pose
  /// ask for other accelerations than those.
  void require_agreeing_rows(const Coordinates& coordinates) const;

  /// The start: kept and driven values exactly, modal values as given, everything else by Newton's method from the
  /// model's guesses; whole turns are counted apart from then on. Throws InputError, naming the joints, if the kept
  /// values are too many, too few, dependent or contradictory, and naming body and axis if the opened tree lacks
  /// inertia.
  [[nodiscard]] Coordinates start();

  /// Closes q and u near their values at time t, couplings and nonholonomic constraints too. Modal coordinates and
  /// rates are kept, unless the loops restrict them, as where a flexible body is held at both ends: then they move by
  /// the shortest steps too. False if Newton's method fails.
  [[nodiscard]] bool close(Coordinates& coordinates);

  /// Projects a state that is closed but for the error of one integration step: the smallest change in the units of the
  /// machine, of joint coordinates where these can close it, else of modes too. Throws SolverError, naming the joint
  /// and the residual, if the loops will not close.
  void project(Coordinates& coordinates);

  /// Decides how many closure rows are independent in a general pose near the start (from `coordinates`, if the machine
  /// has no start), and what closing has to move; once.
  void decide_rank(const Coordinates& coordinates);
  [[nodiscard]] int rank() const { return equations_->loops().rank(); }

  /// After an evaluation in a closed pose: throws SingularPose, naming loop and time, if fewer closure rows are
  /// independent there than in a general pose.
  void require_general_rank(const Coordinates& coordinates);
  /// Throws that; `passing` comes before "lose rank".
  [[noreturn]] void throw_singular(const Coordinates& coordinates, const std::string& passing);

  /// Closure rows in machine units over the free columns, and the size of the smallest singular value that a general
  /// pose has.
  double factor_rows(Coordinates& coordinates, MatX& Phi);
  /// Closes positions near the given ones; false where Newton's method fails.
  [[nodiscard]] bool close_positions_nearby(Coordinates& coordinates);

  /// Largest misfit of position and velocity closure in machine units, as the projection measures it: position residual
  /// / max(1, largest coordinate), velocity residual relative to the largest speed.
  [[nodiscard]] double misfit(const Coordinates& coordinates);

  enum class Modes { kept, moving };
  /// The closure rows that hold for positions, or all rows, which hold for velocities.
  enum class Rows { of_positions, of_velocities };

  /// Rank of the closure rows in scaled units over the free columns of the tree, with or without modal ones.
  [[nodiscard]] int closure_rank(const Coordinates& coordinates, Rows rows, Modes modes);

 private:
  [[nodiscard]] bool close_positions(Coordinates& coordinates, const PrescribedMask& prescribed, Modes modes);
  [[nodiscard]] bool close_velocities(Coordinates& coordinates, const PrescribedMask& prescribed, Modes modes);
  void decide_modes(const Coordinates& closed);
  [[nodiscard]] std::vector<int> moving_columns(const PrescribedMask& prescribed, Modes modes) const;
  void advance(VecX& q, const VecX& step) const;
  double measure(Coordinates& coordinates, Closure& closure);
  double try_to_measure(Coordinates& coordinates, Closure& closure);
  [[nodiscard]] VecX smallest_step(const Closure& closure, const std::vector<int>& columns, const VecX& misfit,
                                   double damping) const;
  void move(Coordinates& coordinates);
  void take_projection();
  [[nodiscard]] VecX projection_step(const VecX& misfit) const;
  [[nodiscard]] const VecX& projection_weights() const {
    return projecting_ == Modes::kept ? weights_of_joints_ : weights_of_all_;
  }
  void project_positions(Coordinates& coordinates);
  void project_velocities(Coordinates& coordinates);
  void normalize(VecX& q) const;
  void decide_rank_near(const Coordinates& coordinates);
  [[nodiscard]] double position_residual_in_units() const;
  [[nodiscard]] double velocity_residual_in_units() const;
  [[nodiscard]] double size_of_q(const VecX& q) const;
  [[nodiscard]] double size_of_u(const VecX& u) const;

  [[nodiscard]] Coordinates guess_start() const;
  void measure_unsaid(Coordinates& coordinates) const;
  [[nodiscard]] PrescribedMask kept(StartRole WordStart::*role) const;
  void add_turns_of_couplings(Coordinates& coordinates, const PrescribedMask& prescribed) const;
  void require_independent_start(const Coordinates& coordinates, const PrescribedMask& prescribed, Rows rows);
  void require_number_of_kept(const Coordinates& coordinates, const PrescribedMask& prescribed, Rows rows);
  [[noreturn]] void throw_not_closing(const PrescribedMask& prescribed) const;
  void choose_branches(Coordinates& closed, const Coordinates& said, const PrescribedMask& prescribed_q,
                       const PrescribedMask& prescribed_u) const;
  void require_kept(const Coordinates& closed, const Coordinates& said) const;
  void require_inertia(const Coordinates& coordinates);
  [[nodiscard]] std::string names_of_kept(const PrescribedMask& prescribed) const;
  [[nodiscard]] std::string couplings_of_kept(const PrescribedMask& prescribed) const;
  [[nodiscard]] SourceLocation where_kept(const PrescribedMask& prescribed) const;

  Equations* equations_;
  Scales scales_;
  std::vector<int> all_columns_;
  Modes projecting_ = Modes::moving;
  // By column of all_columns_: as if it were this part of itself.
  VecX weights_of_joints_;
  VecX weights_of_all_;
  RowFactors row_factors_;
  RowFactors position_factors_;  // of the rows for positions, where there are others
  double rate_;                  // machine_rate
  VecX coordinate_units_;
  bool rank_is_decided_ = false;
  Modes closing_modes_ = Modes::kept;  // decided with the rows
};

}  // namespace concord::relative
