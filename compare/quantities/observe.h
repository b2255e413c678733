#pragma once

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/quantity.h"

/// Everything that is compared, as one list of numbers for each state.
namespace concord::compare {

/// A solver's result lacks something that the model asks for: no verdict is possible.
class IncompleteResult : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// "F_x", "F_y", "F_z", "T_x", "T_y", "T_z".
const std::array<std::string, 6>& component_names();

/// The list of quantities of a model, always in the same order, that of Quantity: the rows of every series.
class QuantityLayout {
 public:
  explicit QuantityLayout(const Model& model);

  [[nodiscard]] const Model& model() const { return *model_; }
  [[nodiscard]] const std::vector<Quantity>& quantities() const { return quantities_; }

  /// Row of a quantity.
  [[nodiscard]] int row_of(const Quantity& quantity) const;
  /// First row of the six of a wrench (reaction, reaction_global, total, element, body_sum), or of an acceleration.
  [[nodiscard]] int first_row(Kind kind, int owner, Side side = Side::child) const;

  /// All quantities of one state. Throws IncompleteResult if a body, a joint, a coupling or a force element is missing.
  [[nodiscard]] VecX observe(const State& state, const Evaluation& evaluation) const;
  /// The same of what `solver` says. Throws IncompleteResult, too, if one is no number or beyond 1e150: its square
  /// overflows, and beside a scale that is infinite nothing differs.
  [[nodiscard]] VecX observe_to_judge(const State& state, const Evaluation& evaluation, std::string_view solver) const;

 private:
  void add_block(Kind kind, int owner, Side side, int components);

  const Model* model_;
  std::vector<Quantity> quantities_;
};

/// "joint D on slider", "coordinate force of joint A", "driver of joint A", "coupling gear", "force element strut on
/// axle", "body coupler". Where one actor alone acts on a coordinate, the coordinate force is called after it.
std::string describe_owner(const Model& model, const Quantity& quantity);

/// "F_x", "tau_1", "vdot_x", "addot_2".
std::string describe_component(const Quantity& quantity);

/// Place of a coupled coordinate's speed among the speeds of its joint.
int speed_of(const Model& model, const CouplingTerm& term);
/// Whether a coupled coordinate is an angle, so that a torque acts on it.
bool is_turn(const Model& model, const CouplingTerm& term);

/// The unit of a coupling's force is that of its first term's coordinate force, whose factor counts as a number:
/// "N", "N m", "m/s2", "rad/s2", or "1/s2" for modal accelerations.
std::string unit_of(const Model& model, const Quantity& quantity);

/// "driver", "motor", "spring", "damper".
const char* name_of(Actor actor);

/// The actors of a joint's own on one of its speeds, couplings aside.
std::vector<Actor> actors_on(const Joint& joint, int speed);

/// Whether more than one actor, couplings among them, acts on a speed of joint k.
bool is_shared(const Model& model, int k, int speed);

/// Whether a row is one of the forces of drivers, motors, springs, dampers and couplings, each once: not the sum on a
/// coordinate where several share it.
bool is_told_force(const Model& model, const Quantity& quantity);

/// Speeds of joint k on which a driver, a spring, an actuator or a coupling acts, in the order of the speeds.
std::vector<int> forced_speeds(const Model& model, int k);

/// Place of a joint's point on one side in global axes, deformed [m].
Vec3 joint_point(const Model& model, const State& state, const Joint& joint, Side side);

/// Total wrench of all the model's joints on each body at its origin, global axes [N, N m].
std::vector<Wrench> totals_on_bodies(const Model& model, const State& state, const Evaluation& evaluation);

}  // namespace concord::compare
