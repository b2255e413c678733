#pragma once

#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "common/types.h"

/// A body cut free: d'Alembert's sum over its mass points and what acts on it.
namespace concord::compare {

/// The mass points of a flexible body; of a rigid one, six that have its inertia, which are kept in `of_rigid`.
const std::vector<MassPoint>& mass_points_of(const Body& body, std::vector<MassPoint>& of_rigid);

/// [kg]
double mass_of(const Body& body);

/// Of each mode [kg].
VecX modal_masses(const ModalData& modal);

/// How far each mode with unit amplitude moves the body, at most over its mass points [m].
VecX largest_displacements(const Body& body);

/// The same, and over its nodes, whose turns count at `length` [m].
VecX largest_ways(const Body& body, double length);

/// Six rigid rows and m modal rows, with the sum of the sizes of what was added as a scale of each kind.
struct Balance {
  explicit Balance(int n_modes) : rows(VecX::Zero(6 + n_modes)), scales(VecX::Zero(6 + n_modes)) {}

  VecX rows;
  VecX scales;

  void raise_scales(const VecX& terms);
};

/// The bodies of a model, each with its mass points and with the ends of joints and force elements on it.
class FreeBodies {
 public:
  /// The model must outlive this object.
  explicit FreeBodies(const Model& model);

  /// d'Alembert's sum on a body in global axes: inertia of its mass points, weight, stiffness and damping, minus the
  /// total wrenches of joints and the wrenches of force elements on it.
  [[nodiscard]] Balance balance_of(int body, const State& state, const Evaluation& evaluation) const;

  /// Sets a modal row to zero if it is at most 64 units of round-off of the sum of the sizes of what each force on the
  /// body adds to it. This sum counts forces that cancel, such as the axial forces at the two ends of a strut.
  void forget_round_off_of_forces(int body, const State& state, const Evaluation& evaluation, Balance& balance) const;

 private:
  /// One end of a joint or a force element.
  struct End {
    const Attachment* place;
    Side side;
    std::size_t owner;
    bool is_of_joint;
  };

  [[nodiscard]] const std::vector<MassPoint>& points_of(int body) const;
  /// What acts there, in global axes.
  [[nodiscard]] static const Wrench& wrench_at(const End& end, const Evaluation& evaluation);

  const Model& model_;
  std::vector<std::vector<MassPoint>> points_of_rigid_;  // of each body; of flexible ones none
  std::vector<std::vector<End>> ends_;                   // on each body
};

/// Largest force in the machine [N]: of joints, of elements, and of springs, drivers and couplings on joint speeds. A
/// torque on a joint speed counts as a force at the machine's length. Forces on joint speeds are counted because total
/// wrenches do not show them where a joint balances its own springs, or a gear a motor with a brake.
double largest_force_in(const Model& model, const Evaluation& evaluation);

/// Largest torque in the machine [N m]: of joints and elements about the points where they act, and of the largest
/// force at the machine's length. Torques are counted because a couple may twist a shaft without any force.
double largest_torque_in(const Model& model, const Evaluation& evaluation);

}  // namespace concord::compare
