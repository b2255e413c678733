#include "relative/start/assembly.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "relative/rank/closing.h"

namespace concord::relative {

Assembly::Assembly(Equations& equations)
    : scaled_(equations), start_(scaled_), projection_(scaled_), closure_rank_(scaled_) {}

Coordinates Assembly::start() {
  Coordinates start = start_.find();
  if (!closure_rank_.is_decided()) closure_rank_.decide_near(start);
  return start;
}

bool Assembly::close(Coordinates& coordinates) {
  const Equations& equations = scaled_.equations();
  if (equations.model().is_flexible()) decide_rank(coordinates);
  equations.prescribe(coordinates.t, coordinates.q, coordinates.u);
  const Modes modes = closure_rank_.closing_modes();
  if (!close_at_rank(coordinates, modes) && !close_positions(scaled_, coordinates, equations.driven(), modes)) {
    return false;
  }
  return close_velocities(scaled_, coordinates, equations.driven(), modes);
}

/// Positions of a machine whose rows are dependent, with as many as are independent in closed poses; false, and
/// nothing moved, where that does not close it.
bool Assembly::close_at_rank(Coordinates& coordinates, Modes modes) const {
  if (!closure_rank_.is_decided() || closure_rank_.rank() == scaled_.closure().n_rows()) return false;
  Coordinates closed = coordinates;
  if (!close_positions(scaled_, closed, scaled_.equations().driven(), modes, closure_rank_.rank())) return false;
  coordinates = std::move(closed);
  return true;
}

/// From the start, so that it does not depend on the states that came before; if the machine has none, from here.
void Assembly::decide_rank(const Coordinates& coordinates) {
  if (closure_rank_.is_decided() || scaled_.closure().n_rows() == 0) return;
  Equations& equations = scaled_.equations();
  const VecX turns = equations.kinematics().turns();
  try {
    closure_rank_.decide_near(start_.find());
  } catch (const std::runtime_error&) {  // a start that contradicts itself, or that cannot be evaluated
  }
  equations.count_turns(turns);
  if (!closure_rank_.is_decided()) closure_rank_.decide_near(coordinates);
}

double Assembly::misfit(const Coordinates& coordinates) {
  scaled_.equations().move(coordinates.t, coordinates.q, coordinates.u);
  return std::max(scaled_.position_residual() / std::max(1.0, scaled_.size().largest_coordinate(coordinates.q)),
                  scaled_.velocity_residual() / scaled_.size().rate_at(coordinates.u));
}

}  // namespace concord::relative
