#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cartesian/bodies/indices.h"
#include "cartesian/dynamics/equations.h"
#include "cartesian/rank/kept_rows.h"
#include "cartesian/rank/sparse_qr.h"
#include "common/start_words.h"

namespace concord::cartesian {

/// How far closing came: the largest residuals in the machine's units (its length, rad; for velocities 1/s).
struct Closing {
  bool closed = false;
  bool places_closed = false;  // on the branch that the joints mean; what is left then is in the velocities
  double position_residual = 0.0;
  double velocity_residual = 0.0;
  std::vector<std::string> joints_left_open;  // those with the largest residuals, if not closed
  bool is_off_branch = false;                 // closed, but with a joint half a turn from where it means to be
  std::vector<std::string> couplings_left_open;
};

/// Whether closing moves modal coordinates and rates too, or the rigid ones alone.
enum class Modes { kept, moving };

/// What closing holds: all constraints, these and the coordinates and speeds that the start keeps, or the joints and
/// couplings without drivers.
enum class Hold { constraints, start, joints_alone };

/// Of readings that count turns by themselves, as the height on a thread does: the joint that reads farthest from its
/// known coordinate q (by joint) at the last update, and by how much.
struct TurnError {
  JointIndex joint;
  double size = 0.0;  // rad
  double read = 0.0;
  double known = 0.0;
};
/// Nothing if there is no such reading.
std::optional<TurnError> largest_turn_error(const Equations& equations, const std::vector<VecX>& q);

/// Moves q by shortest steps towards these coordinates of such readings with all other constraints held, so that a
/// perturbed machine closes on the turns that it is said to be on. Leaves q as it is where that fails.
void seek_turns(Equations& equations, double t, Modes modes, const std::vector<VecX>& known, VecX& q, const VecX& Y);

/// Whether the constraints at the last update of `equations` restrict the modes, as where a flexible body is held at
/// both ends: rigid coordinates alone cannot close such a machine.
bool modes_are_restricted(const Equations& equations);

/// Moves q and Y by the shortest steps until all constraints hold as far as round-off lets, at time t: at most 1e-13 in
/// the machine's units, of the distance from the origin beyond one length, of the largest speed. Rows that hold for
/// velocities alone restrict no position. Turns of coupled coordinates are counted on the way, from those that
/// `equations` count from. `rank`: of the constraints in closed poses; those of a linkage that moves though it is
/// overconstrained have more beside them, and steps along its motion that go with it are not taken.
Closing close_machine(Equations& equations, double t, Hold hold, Modes modes, VecX& q, VecX& Y,
                      std::optional<int> rank = {});
/// The same by the solver that closed the machine before, perhaps in this pose.
Closing close_machine(Equations& equations, double t, Hold hold, Modes modes, VecX& q, VecX& Y, ShortestSolver& solver,
                      std::optional<int> rank = {});

/// Words whose coordinates (speeds) a start can keep in this state, as many as are free and independent of each other:
/// kept ones first, then others in the order of the model. None where there are no such words, or too many to be named.
std::vector<StartWord> words_to_keep(Equations& equations, double t, const VecX& q, const VecX& Y, Kept what);

/// Numbers of kept coordinates and kept speeds (a ball counts 3 of each), and how many of the kept rows the constraints
/// leave free. Rows that hold for velocities alone leave more freedom to coordinates than to speeds.
struct KeptCount {
  int coordinates = 0;
  int speeds = 0;
  int speeds_kept_as_wholes = 0;  // those beside the first of words with several, which nobody can leave out alone
  int coordinate_freedom = 0;     // rigid degrees of freedom at the state, modal coordinates held
  int speed_freedom = 0;
  int independent_coordinates = 0;
  int independent_speeds = 0;
};
/// `coarse`: what rows have of their own counts from 1e-6 of the largest on, instead of 1e-10.
KeptCount count_kept(Equations& equations, double t, const VecX& q, const VecX& Y, bool coarse = false);

}  // namespace concord::cartesian
