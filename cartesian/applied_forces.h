#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cartesian/constraints.h"
#include "cartesian/layout.h"
#include "common/model.h"
#include "common/results.h"

/// Generalized forces of force elements and of springs on joint coordinates.
namespace concord::cartesian {

/// Whose forces an actor's are.
struct OfElement {
  int element = 0;  // index in Model::elements
};
struct OfSprings {
  int joint = 0;  // index in Model::joints
};

/// What pushes on two bodies at once (a load: on one, the child): an element of the model, or the springs of one joint.
struct Actor {
  std::variant<OfElement, OfSprings> owner;
  std::array<const Attachment*, 2> ends{nullptr, nullptr};
  std::array<Marker, 2> markers;  // of an element; a joint has its own
  RelativeMotion motion;          // of an element: the child's end seen from the parent's
  TireRegime regime;              // of a tire
  /// Of the stops of a spring, or of each spring of a joint in its order.
  std::vector<LawRegime> stop_regimes;
  /// Wrenches at the ends, global axes, and their generalized forces (C12) on the ends' bodies, 6 + m numbers (none on
  /// ground).
  std::array<Wrench, 2> wrenches;
  std::array<VecX, 2> forces;
  /// Of a joint's springs: coordinate forces (n_u numbers), whether each spring's coordinate is an angle known but for
  /// full turns, and the angles that the last known turns are counted from.
  VecX tau;
  std::vector<bool> spring_turns;
  VecX known_q;

  /// The joint whose springs push; nothing for an element.
  [[nodiscard]] std::optional<int> joint() const {
    const auto* springs = std::get_if<OfSprings>(&owner);
    return springs != nullptr ? std::optional(springs->joint) : std::nullopt;
  }
  [[nodiscard]] bool sits_on_moving_body(Side side) const {
    return ends[index(side)] != nullptr && ends[index(side)]->body != kGround;
  }
};

/// The line of a line spring at some time.
struct SpringLine {
  const std::string* name;
  Vec3 span;                     // from the parent's end to the child's, global axes [m]
  Vec3 rate;                     // its rate of change [m/s]
  bool is_reversed_with_a_jump;  // the force jumps where the ends pass each other at the present speed
};

class AppliedForces {
 public:
  /// Both must outlive this object.
  AppliedForces(const Model& model, const Layout& layout, const Constraints& constraints);

  /// Wrenches and generalized forces of all actors at time t, positions q and velocities Y, after place() and move() of
  /// the constraints. Throws SolverError, naming the element, where its law has no direction: a line spring of no
  /// length, a turn spring or a bushing beyond 175 deg, a turn spring whose axis x points along z, a tire whose axis
  /// stands upright on the road.
  void update(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);
  void update(Actor& actor, double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) const;

  /// Whether tires and stops keep the regimes that they are in (an integrator does so during a step); else every
  /// update() takes the regime that each is in by itself.
  void freeze_regimes(bool hold) { regimes_are_frozen_ = hold; }
  [[nodiscard]] bool has_regimes() const;
  /// How far tires and stops are inside their regimes (event_functions_of) at time t, positions q and velocities Y. The
  /// result is overwritten by the next call.
  const VecX& event_functions(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y);
  [[nodiscard]] Eigen::Index n_event_functions() const { return event_values_.size(); }
  /// The actor whose event function has a given index.
  [[nodiscard]] int owner_of_event(Eigen::Index function) const { return event_owners_[function]; }

  /// Adds the generalized forces to `forces` (n_Y numbers).
  void add_to(Eigen::Ref<VecX> forces) const;

  /// Power of all of them [W] at velocities Y.
  [[nodiscard]] double power(const Eigen::Ref<const VecX>& Y) const;

  /// "tire 'left'", "the stop of 'coil'": what an actor's regimes belong to.
  [[nodiscard]] std::string name_of_regime(int actor) const;

  [[nodiscard]] std::vector<Actor>& actors() { return actors_; }

  /// The springs of joint k; nullptr if it has none.
  [[nodiscard]] const Actor* springs_of(int k) const;
  /// Wrenches of element e on both its ends.
  [[nodiscard]] ElementWrenches element(int e) const;

  /// The line springs as they lie at the last update, which was at time t, in the order of the model.
  [[nodiscard]] std::vector<SpringLine> spring_lines(double t) const;

  /// Joint coordinates (by joint) from which the turns of sprung angles are counted: at most half a turn away.
  void count_turns_from(const std::vector<VecX>& q);

 private:
  /// The element whose force an actor is; nullptr for springs of a joint.
  [[nodiscard]] const ForceElement* element_of(const Actor& actor) const;
  [[nodiscard]] bool has_regimes(const Actor& actor) const;
  void place_end(Actor& actor, Side side, const Mat3& A, const Eigen::Ref<const VecX>& q,
                 const Eigen::Ref<const VecX>& Y) const;
  void place_ends(Actor& actor, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) const;
  void apply_springs(Actor& actor, double t) const;
  void lay_out_events();
  /// Writes the event functions of an actor whose ends are placed, and returns what comes after them.
  double* write_event_functions(const Actor& actor, double t, double* next) const;

  const Model& model_;
  const Layout& layout_;
  const Constraints& constraints_;
  double shortest_line_;
  std::vector<Actor> actors_;                         // elements in the order of the model, then joints with springs
  std::vector<std::optional<int>> springs_of_joint_;  // index in actors_, if the joint has springs
  bool regimes_are_frozen_ = false;
  std::vector<int> event_owners_;  // by event function
  VecX event_values_;
};

}  // namespace concord::cartesian
