#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cartesian/bodies/constraints.h"
#include "cartesian/bodies/indices.h"
#include "cartesian/bodies/layout.h"
#include "cartesian/forces/applied_force.h"
#include "cartesian/forces/spring_forces.h"
#include "common/model.h"
#include "common/results.h"

/// Generalized forces of force elements and of springs on joint coordinates.
namespace concord::cartesian {

/// The regimes of all tires and stops, by applied force.
struct RegimesOfAll {
  std::vector<TireRegime> of_tires;
  std::vector<std::vector<LawRegime>> of_stops;
};

class AppliedForces {
 public:
  /// Both must outlive this object.
  AppliedForces(const Model& model, const Layout& layout);

  /// Wrenches and generalized forces of all applied forces at time t, positions q and velocities Y, which are those of
  /// the constraints `at`: bodies' rotations and joints' motions come from there. Throws SolverError, naming the
  /// element, where its law has no direction (exert).
  void update(const MovingConstraints& at, double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);
  /// The same of one applied force.
  void update(const MovingConstraints& at, AppliedForceIndex applied, double t, const Eigen::Ref<const VecX>& q,
              const Eigen::Ref<const VecX>& Y);

  /// Whether tires and stops keep the regimes that they are in (an integrator does so during a step); else every
  /// update() takes the regime that each is in by itself.
  void freeze_regimes(bool hold) { regimes_ = hold ? Regimes::kept : Regimes::own; }
  [[nodiscard]] bool has_regimes() const { return n_event_functions() > 0; }
  /// The regimes of the last update, and keeps such from now on.
  [[nodiscard]] RegimesOfAll regimes() const;
  void keep_regimes(const RegimesOfAll& regimes);
  /// How far tires and stops are inside their regimes (event_functions_of) at time t, positions q and velocities Y,
  /// wherever the constraints `near` are: they tell the sides that arms stand on. Overwritten by the next call.
  const VecX& event_functions(const PlacedConstraints& near, double t, const Eigen::Ref<const VecX>& q,
                              const Eigen::Ref<const VecX>& Y);
  [[nodiscard]] Eigen::Index n_event_functions() const { return event_values_.size(); }
  /// The applied force whose event function has a given index.
  [[nodiscard]] AppliedForceIndex owner_of_event(Eigen::Index function) const { return event_owners_[function]; }
  /// Of the last update, with its constraints and time: whose force departs from its law by more than
  /// kLargestDeparture.
  [[nodiscard]] std::optional<AppliedForceIndex> departed(const MovingConstraints& at, double t) const;
  /// "tire 'left'", "the stop of 'coil'": what an applied force's regimes belong to.
  [[nodiscard]] std::string name_of_regime(AppliedForceIndex applied) const;

  /// Adds the generalized forces to `forces` (n_Y numbers).
  void add_to(Eigen::Ref<VecX> forces) const;

  /// Power of all of them [W] at velocities Y.
  [[nodiscard]] double power(const Eigen::Ref<const VecX>& Y) const;

  /// Elements in the order of the model, then joints with springs.
  [[nodiscard]] const ByAppliedForce<AppliedForce>& applied_forces() const { return applied_forces_; }
  /// The springs of joint k; nullptr if it has none.
  [[nodiscard]] const AppliedForce* springs_of(JointIndex k) const;
  /// Wrenches of element e on both its ends.
  [[nodiscard]] ElementWrenches element(ElementIndex e) const;

  /// The line springs as they lie at the last update, which was at time t, in the order of the model.
  [[nodiscard]] std::vector<SpringLine> spring_lines(double t) const;
  /// How fast one of them turns or changes its length at most there, as a part of its length [1/s].
  [[nodiscard]] double fastest_line_rate() const;

  /// Joint coordinates (by joint) from which the turns of sprung angles are counted: at most half a turn away.
  void count_turns_from(const std::vector<VecX>& q);
  /// The same of the angles of turn springs, from those of a state; and on from those of the last update.
  void count_spring_turns_from(const State& state);
  void follow_spring_turns();
  /// The angle of each element that is a turn spring at positions q and velocities Y, which are those of `at`; zero for
  /// others (State::spring_angles).
  [[nodiscard]] std::vector<double> spring_angles(const MovingConstraints& at, const Eigen::Ref<const VecX>& q,
                                                  const Eigen::Ref<const VecX>& Y) const;
  /// Counts all turns from where the forces of another copy of the same machine do, and holds the regimes that those
  /// hold.
  void count_turns_and_hold_regimes_as(const AppliedForces& other);

 private:
  /// Calls visit(index of the element, its applied force) for each turn spring.
  template <class Visit>
  void each_turn_spring(const Visit& visit) const;
  AppliedForce make_applied_force(const ForceElement& element, ElementIndex e) const;
  AppliedForce make_applied_force(const Joint& joint, JointIndex k) const;
  void make_end(const Attachment& end, Side side, AppliedForce& applied) const;
  /// The element whose force an applied force is; nullptr for springs of a joint.
  [[nodiscard]] const ForceElement* element_of(const AppliedForce& applied) const;
  /// Calls visit(name, spring, its applied force) for each line spring.
  template <class Visit>
  void each_line_spring(const Visit& visit) const;
  [[nodiscard]] ForceInstant instant_of(const ForceElement& element, const Mat3& A_child, double t) const;
  void place_end(AppliedForce& applied, Side side, const Mat3& A, const Eigen::Ref<const VecX>& q,
                 const Eigen::Ref<const VecX>& Y) const;
  /// Ends on moving bodies with these rotations, and the child's end seen from the parent's.
  template <class RotationOf>
  void place_ends(AppliedForce& applied, const RotationOf& rotation_of_body, const Eigen::Ref<const VecX>& q,
                  const Eigen::Ref<const VecX>& Y) const;
  void lay_out_events();

  const Model& model_;
  const Layout& layout_;
  double shortest_line_;
  ByAppliedForce<AppliedForce> applied_forces_;
  ByJoint<std::optional<AppliedForceIndex>> springs_of_joint_;  // if the joint has springs
  Regimes regimes_ = Regimes::own;
  std::vector<AppliedForceIndex> event_owners_;  // by event function
  VecX event_values_;
};

}  // namespace concord::cartesian
