#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/line_watch.h"
#include "common/results.h"
#include "relative/bodies/motion.h"
#include "relative/closure/closure.h"
#include "relative/forces/element_wrench.h"
#include "relative/forces/tire_contact.h"

/// Applied forces: force elements and joint springs as generalized forces of bodies and of joint speeds.
namespace concord::relative {

/// Everything that pushes besides gravity, modal stiffness and drivers. A wrench w at a point adds G_P^T w to its body:
/// six rows at the body's reference point and the modal rows (R8). A joint spring in
/// the tree adds its coordinate force to the joint's speed; on a cut joint its coordinate wrench goes on both bodies.
/// All memory is laid out at construction.
class AppliedForces {
 public:
  /// Both must outlive this object.
  AppliedForces(const Kinematics& kinematics, const Closure& closure);

  /// Takes a motion, of which kinematics and closure hold the pose. Throws SolverError, naming the element, where a
  /// line spring's ends meet and its force jumps there, or where frames that resist turning are turned by more than 175
  /// deg, or where a turn spring has no angle, or where a wheel lies flat on the road.
  void update(const Motion& motion);

  /// Counts the turns of the turn springs from the angles of a state, or as those of another copy of the machine.
  void count_turns_from(const State& state);
  void count_turns_as(const AppliedForces& other);
  /// Counts them on from the last update, whose motion the machine has taken.
  void follow_turns();
  /// Throws SolverError, naming the element, where the last update is not clear about the turn that a turn spring is
  /// on: too long after the last motion that was taken.
  void require_seen_turns() const;
  [[nodiscard]] bool has_turn_springs() const { return !turn_springs_.empty(); }
  /// The angle of each element that is a turn spring in a motion that kinematics hold; zero for others
  /// (State::spring_angles).
  [[nodiscard]] std::vector<double> spring_angles(const Motion& motion) const;

  /// Tires and stops: each update takes the regime that a contact is in by itself, or keeps the regimes that the last
  /// update found, as an integrator needs during a step.
  void free_regimes() { regimes_are_frozen_ = false; }
  void freeze_regimes() { regimes_are_frozen_ = true; }
  [[nodiscard]] bool has_regimes() const { return has_regimes_; }
  /// The regimes of all contacts, as the last update found or kept them.
  struct ContactRegimes {
    std::vector<TireRegime> of_tires;
    std::vector<LawRegime> of_laws;
  };
  [[nodiscard]] ContactRegimes contact_regimes() const;
  /// Keeps these from now on.
  void freeze_regimes(const ContactRegimes& regimes);
  /// How far the last update was inside the regimes of all tires, stops and tables: see event_functions_of. Writes
  /// n_event_functions() numbers.
  void write_event_functions(Eigen::Ref<VecX> values) const;
  [[nodiscard]] int n_event_functions() const {
    return kTireEvents * static_cast<int>(tires_.size()) + kLawEvents * static_cast<int>(laws_.size());
  }
  /// "tire 'left'", "law of 'coil'": of whom the smallest event function is.
  [[nodiscard]] std::string least_contact() const;
  /// A tire, or a law with stops or tables.
  struct Contact {
    const char* kind;
    const std::string* owner;
    [[nodiscard]] std::string name() const;
  };
  /// Whose force at the last update departs from its law by more than kLargestDeparture.
  [[nodiscard]] std::optional<Contact> departed_contact() const;

  /// Generalized force on the body of a link: six rigid rows about its reference point, global axes, and its modal
  /// rows.
  [[nodiscard]] const Vec6& on_body(LinkIndex link) const { return on_body_[link]; }
  [[nodiscard]] const VecX& on_modes(LinkIndex link) const { return on_modes_[link]; }

  /// Coordinate force of the joint springs on every speed (n_u numbers, those of cut joints too).
  [[nodiscard]] const VecX& tau() const { return tau_; }
  /// What of it is the law of time of a motor.
  [[nodiscard]] const VecX& tau_of_motors() const { return tau_of_motors_; }
  /// Writes what of it acts without the rate, n_u numbers: the laws once more, at rest. The rate adds the rest.
  void write_tau_of_springs(VecX& tau) const;
  /// Coordinate wrench of the springs of a cut joint on its child at P_i, global axes.
  [[nodiscard]] const Vec6& on_child_of_cut(CutIndex cut) const { return on_child_of_cut_[cut]; }

  /// What each force element exerts, in the order of the model.
  [[nodiscard]] const std::vector<ElementWrenches>& elements() const { return wrenches_; }

  /// The lines of the line springs, in the order of the model, at the last update, which was at time t.
  [[nodiscard]] std::vector<SpringLine> lines(double t) const;
  [[nodiscard]] bool has_line_springs() const;

  /// Power of all force elements and joint springs [W].
  [[nodiscard]] double power() const { return power_; }
  [[nodiscard]] bool any() const { return !elements_.empty() || !springs_.empty(); }

 private:
  /// A force element and its ends; a load has the child's only.
  struct Element {
    const ForceElement* statement;
    std::vector<JointPoint> ends;  // by Side, or the child's alone
    std::array<BodyIndex, 2> bodies{BodyIndex(kGround), BodyIndex(kGround)};
    std::optional<int> tire;  // its index among the tires
    std::optional<int> law;   // of a spring, its index among the laws
    CountedAngle angle;       // of a turn spring
  };
  struct TireState {
    const ForceElement* statement;
    std::size_t element;  // its index among the elements
    TireRegime regime;
    TireContact contact;
  };
  /// A joint spring and the indices of its coordinate and speed.
  struct Spring {
    int law;  // its index among the laws
    int q, u;
    double place = 0.0;  // its coordinate at the last update, turns included
  };
  /// The law of a line or turn spring or of a joint spring, and whose it is.
  struct OwnedLaw {
    LawInRegime law_in_regime;
    const std::string* owner;
  };

  void lay_out_elements();
  void lay_out_springs();
  void clear();
  void move_ends(Element& element, const Motion& motion) const;
  /// The wrench on the child, one evaluator for each kind of element.
  [[nodiscard]] Vec6 exerted(const Load& load, double t, const Element& element) const;
  [[nodiscard]] Vec6 exerted(const LineSpring& spring, double t, const Element& element);
  [[nodiscard]] Vec6 exerted(const TurnSpring& spring, double t, Element& element);
  /// Of a kind that its two ends determine alone.
  template <class Passive>
  [[nodiscard]] Vec6 exerted(const Passive& passive, double /*t*/, const Element& element) const {
    return wrench_of(passive, element.ends.front(), element.ends.back(), element.statement->name);
  }
  [[nodiscard]] Vec6 exerted(const Tire& tire, double t, const Element& element);
  [[nodiscard]] double departure_of(const TireState& state) const;
  int add_law(const ForceLaw& law, const std::string& owner);
  /// The smallest event function, and whose contact has it.
  struct Least {
    double value;
    Contact contact;
  };
  [[nodiscard]] Least least() const;
  void apply_element(double t, Element& element, ElementWrenches& wrenches);
  void apply_springs(const Motion& motion);
  void apply_wrench(BodyIndex body, const JointPoint& point, const Vec6& wrench);

  const Kinematics* kinematics_;
  const Closure* closure_;
  std::vector<Element> elements_;
  std::vector<std::size_t> turn_springs_;  // which elements are
  std::vector<Spring> springs_;
  std::vector<TireState> tires_;
  std::vector<OwnedLaw> laws_;
  bool has_regimes_ = false;
  bool regimes_are_frozen_ = false;
  std::vector<CutIndex> sprung_cuts_;
  std::vector<Vec6> on_body_;
  std::vector<VecX> on_modes_;
  std::vector<Vec6> on_child_of_cut_;
  std::vector<ElementWrenches> wrenches_;
  VecX tau_;
  VecX tau_of_motors_;
  double power_ = 0.0;
};

}  // namespace concord::relative
