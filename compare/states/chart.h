#pragma once

#include <functional>
#include <optional>
#include <string>

#include "common/solver.h"
#include "compare/states/modal_sizes.h"

/// Local coordinates of a machine about a closed state: the ground on which analyses differentiate.
namespace concord::compare {

/// As many coordinates delta as the machine has degrees of freedom: delta = V^T xi, where xi stacks for each body how
/// far its origin has moved [of the machine's length], the rotation vector from its orientation at the origin of the
/// chart [rad], and the change of its modal coordinates [modal_sizes()]; the columns of V are orthonormal and span the
/// velocities that the solver's constraints permit at the origin. Model and solver must outlive it.
///
/// It ends where the number of permitted directions changes. If a neighbour has fewer of them, the origin is a singular
/// pose: then at() and exactly_at() throw SingularPose with both numbers and the motion that is lost. A neighbour that
/// has more, or whose directions are no longer told apart by V, is none.
class Chart {
 public:
  Chart(const Model& model, Solver& solver, const State& origin);

  [[nodiscard]] int n() const { return static_cast<int>(V_.cols()); }
  /// The first so many coordinates move modes; the others move none. Where loops restrict modes, there are fewer of
  /// them than modes.
  [[nodiscard]] int n_modal() const { return n_modal_; }
  [[nodiscard]] const State& origin() const { return origin_; }
  /// V: rows of bodies 1, 2, ... (6 + m each).
  [[nodiscard]] const MatX& basis() const { return V_; }

  /// The closed state near the coordinates delta, moving with exactly the rates deltadot. Where the manifold is curved
  /// its coordinates differ from delta in second order. Nothing if the solver finds no closed state.
  [[nodiscard]] std::optional<State> at(const VecX& delta, const VecX& deltadot);

  /// n numbers, linear in the velocities of a state.
  using Rates = std::function<VecX(const State&)>;
  /// The same, but moving so that `rates` of it are as wanted.
  [[nodiscard]] std::optional<State> at(const VecX& delta, const Rates& rates, const VecX& wanted);

  /// The closed state near the coordinates delta, at rest where the origin is and drivers are: at() without looking how
  /// many directions of motion it has, which for many bodies costs most. Nothing if the solver finds none.
  [[nodiscard]] std::optional<State> place_at(const VecX& delta) const;

  /// The origin displaced along velocities(delta): open in second order.
  [[nodiscard]] State moved_by(const VecX& delta) const;

  /// The places of the origin with no velocities but velocities(delta).
  [[nodiscard]] State origin_moving(const VecX& delta) const;

  /// The closed state whose coordinates are exactly delta, at rest where drivers are: the same for every solver.
  /// Nothing if it is not found.
  [[nodiscard]] std::optional<State> exactly_at(const VecX& delta);

  /// The same, then closed with modes as delta says. Turns displace joints in second order, and closing shares that out
  /// among bodies and modes: in stiff modes it would cause forces beyond all others.
  [[nodiscard]] std::optional<State> with_modes_at(const VecX& delta);

  /// The rates deltadot of the origin itself.
  [[nodiscard]] VecX rates_at_origin() const;

  /// Second derivatives of the coordinates in a state near the origin [1/s2].
  [[nodiscard]] VecX accelerations(const State& state, const Evaluation& evaluation) const;

  /// Velocities [v; omega; adot] of bodies 1, 2, ... that belong to a change of the coordinates, in SI units.
  [[nodiscard]] VecX velocities(const VecX& delta) const;

  /// The coordinates that change so, as far as the chart permits the velocities.
  [[nodiscard]] VecX coordinates_of(const VecX& velocities) const;
  /// Why the solver refuses the state where the coordinates are delta, closed if it can be; empty if it does not.
  [[nodiscard]] std::string refusal_at(const VecX& delta) const;
  /// velocities(delta) in the words of describe_motion().
  [[nodiscard]] std::string describe(const VecX& delta) const;

 private:
  void put_modes_first();
  [[noreturn]] void refuse_singular_origin(const MatX& map) const;
  [[nodiscard]] MatX scaled_tangent(const State& state) const;
  [[nodiscard]] VecX coordinates(const State& state) const;
  [[nodiscard]] VecX own_rates(const State& state) const;
  void add_velocity(const VecX& scaled, State& state) const;

  const Model& model_;
  Solver& solver_;
  State origin_;
  double length_;
  VecX weights_;  // of the rows: from SI to scaled
  MatX V_;
  int n_modal_ = 0;
};

/// Accelerations of bodies 1, 2, ... in the chart's scaled rows [1/s2].
VecX scaled_accelerations(const Model& model, const Evaluation& evaluation);

/// A derivative and by how much two of its step sizes differ in it: what it may be wrong by, component by component.
struct Derivative {
  VecX value;
  VecX error;
};

/// Derivative at zero of a vector function of one number: central differences with three steps, extrapolated to the
/// sixth order. The first step shrinks, down to `least`, while the function gives nothing and as long as that brings
/// the orders nearer to each other: a jump of a derivative within the step, or round-off, drives them apart. `scale`:
/// what is large for the derivative, so that zeros need no digits. Nothing if the function never gives anything.
std::optional<Derivative> derivative_at_zero(const std::function<std::optional<VecX>(double)>& function, double step,
                                             double least, double scale);

}  // namespace concord::compare
