// Compiled without NDEBUG and as C++17, as the library itself is: see CMakeLists.txt.
#include "compare/oracle/simbody_machine.h"

#include <Simbody.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/error.h"
#include "compare/oracle/plan.h"
#include "compare/oracle/recipes.h"
#include "compare/verdict/not_expressible.h"

namespace concord::compare::oracle {

namespace {

using SimTK::MobilizedBody;
using SimTK::MobilizedBodyIndex;
using SimTK::MobilizerUIndex;
using SimTK::SpatialVec;
using SimTK::Transform;

/// Where Simbody places a body further from the given place than this part of the machine's length, or by this angle
/// [rad], the translation is at fault: states are closed to 1e-13.
constexpr double kMisplaced = 1e-10;

/// Least over largest moment of inertia of a body that is split: what is left of 16 digits is more than the need.
constexpr double kThinnest = 1e-6;

SimTK::Vec3 to_simbody(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 from_simbody(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

SimTK::Rotation to_simbody(const Mat3& A) {
  return SimTK::Rotation(SimTK::Mat33(A(0, 0), A(0, 1), A(0, 2), A(1, 0), A(1, 1), A(1, 2), A(2, 0), A(2, 1), A(2, 2)));
}

/// Simbody weighs rows of lengths against rows of angles when it seeks the rank of the constraints, so a machine is
/// handed over in lengths and masses of its own; the second stays.
struct Units {
  double length = 1.0;  // m
  double mass = 1.0;    // kg

  [[nodiscard]] double force() const { return mass * length; }
  [[nodiscard]] double torque() const { return mass * length * length; }
  /// Of the force on a joint speed.
  [[nodiscard]] double of(const Mobility& mobility) const { return mobility.slides ? force() : torque(); }
  [[nodiscard]] SimTK::Vec3 place(const Vec3& in_m) const { return to_simbody(Vec3(in_m / length)); }
};

Units units_of(const Model& model) {
  Units units{model.length_scale(), 0.0};
  for (const Body& body : model.bodies) units.mass = std::max(units.mass, body.mass);
  if (!(units.mass > 0.0)) units.mass = 1.0;
  return units;
}

/// Unit quaternion to rotation; the scalar stands first in both.
Mat3 rotation_of_state(const BodyState& body) {
  const Vec4 p = body.p.normalized();
  return Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix();
}

/// A frame whose axes are those of the joint's frame in another order.
Mat3 reordered(const Mat3& C, const std::array<int, 3>& axes) {
  Mat3 turned;
  for (int k = 0; k < 3; ++k) turned.col(k) = C.col(axes[k]);
  return turned;
}

/// One of `parts` equal parts of a body: all in the same place. Simbody wants the inertia about the body's origin.
SimTK::Body::Rigid part_of(const Body& body, int parts, const Units& units) {
  const double mass = body.mass / (units.mass * parts);
  const Mat3 I = body.inertia_L / (units.torque() * parts);
  const SimTK::Vec3 center = units.place(body.center_of_mass_L);
  const SimTK::Inertia about_center(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  return SimTK::Body::Rigid(SimTK::MassProperties(mass, center, about_center.shiftFromMassCenter(-center, mass)));
}

/// What stands for ground where a joint has it as its child: it is welded, so any mass does.
SimTK::Body::Rigid part_of_ground() {
  return SimTK::Body::Rigid(SimTK::MassProperties(1.0, SimTK::Vec3(0), SimTK::Inertia(1.0)));
}

/// The length of a link, the radius of a ball, the lead of a screw, as the joint's own type states it.
double length_of_link(const joints::JointType& type) {
  for (const joints::Permit& word : type.permits) {
    if (const auto* arm = std::get_if<joints::Arm>(&word)) return arm->length;
  }
  throw std::logic_error(type.name + " has no arm");
}

double radius_of(const joints::JointType& type) { return std::get<joints::NoSlip>(type.forbids_speeds.front()).below; }

/// The angle of the frames, with as many turns as the place on the thread tells.
double turn_of_screw(const Transform& X_FM, double lead) {
  const SimTK::Mat33& R = X_FM.R().asMat33();
  const double angle = std::atan2(R(1, 0), R(0, 0));
  const double turn = 2.0 * SimTK::Pi;
  return angle + turn * std::round((X_FM.p()[2] / lead - angle) / turn);
}

double lead_of(const joints::JointType& type) {
  const double zero = 0.0;
  joints::FunctionOfCoordinates::Motion motion;
  std::get<joints::ByMotion>(type.permits.front()).motion->evaluate(&zero, &zero, motion);
  return motion.S(2, 0);
}

/// The mobilizers that hold a joint's frame on the parent and its frame on the child: two where there is a link.
struct Frames {
  MobilizedBodyIndex from;
  MobilizedBodyIndex to;
};

/// A joint as it stands in Simbody.
struct BuiltJoint {
  const Joint* joint = nullptr;
  const Recipe* recipe = nullptr;
  MobilizedBodyIndex moved;   // whose mobilizer has the recipe's mobilities: the child's part, or the link
  MobilizedBodyIndex child;   // the child's part
  MobilizedBodyIndex parent;  // the parent itself
  std::vector<SimTK::ConstraintIndex> beside;
  std::vector<bool> is_forced;  // whether something acts on each of the recipe's mobilities

  [[nodiscard]] bool has_link() const { return recipe->link >= 0; }
  [[nodiscard]] Frames frames() const { return {moved, child}; }
  [[nodiscard]] int body_on(Side side) const { return joint->on(side).body; }
};

/// A driven coordinate.
struct BuiltDriver {
  const Driver* driver = nullptr;
  bool slides = false;
  SimTK::ConstraintIndex constraint;
};

/// A mobilizer that lets a body go free.
struct Carrier {
  int body = 0;
  MobilizedBodyIndex moved;
};

template <class Kind, class... Details>
MobilizedBodyIndex add(MobilizedBody& parent, const Transform& on_parent, const SimTK::Body& body,
                       const Transform& on_body, Details... details) {
  return Kind(parent, on_parent, body, on_body, details...).getMobilizedBodyIndex();
}

MobilizedBodyIndex add_mobilizer(const Recipe& recipe, const joints::JointType& type, MobilizedBody& parent,
                                 const Transform& on_parent, const SimTK::Body& body, const Transform& on_body,
                                 const Units& units) {
  switch (recipe.mobilizer) {
    case Mobilizer::weld:
      return add<MobilizedBody::Weld>(parent, on_parent, body, on_body);
    case Mobilizer::pin:
      return add<MobilizedBody::Pin>(parent, on_parent, body, on_body);
    case Mobilizer::slider:
      return add<MobilizedBody::Slider>(parent, on_parent, body, on_body);
    case Mobilizer::cylinder:
      return add<MobilizedBody::Cylinder>(parent, on_parent, body, on_body);
    case Mobilizer::ball:
      return add<MobilizedBody::Ball>(parent, on_parent, body, on_body);
    case Mobilizer::universal:
      return add<MobilizedBody::Universal>(parent, on_parent, body, on_body);
    case Mobilizer::free:
      return add<MobilizedBody::Free>(parent, on_parent, body, on_body);
    case Mobilizer::planar:
      return add<MobilizedBody::Planar>(parent, on_parent, body, on_body);
    case Mobilizer::screw:
      return add<MobilizedBody::Screw>(parent, on_parent, body, on_body, lead_of(type) / units.length);
  }
  throw std::logic_error("a mobilizer without a case");
}

/// Simbody's messages have several lines, indented.
std::string in_one_line(const std::string& message) {
  std::string line;
  for (const char c : message) {
    const bool is_space = c == '\n' || c == ' ';
    if (!is_space) {
      line += c;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  return line.substr(0, line.find_last_not_of(' ') + 1);
}

/// A wrench about one point, about another one: `from` is the vector from the new point to the old one.
Wrench shifted(const Wrench& wrench, const Vec3& from) {
  return {wrench.force, wrench.torque + from.cross(wrench.force)};
}

SideWrench in_both_frames(const Wrench& wrench, const Mat3& A_joint) {
  return {{A_joint.transpose() * wrench.force, A_joint.transpose() * wrench.torque}, wrench};
}

bool is_coupled(const Model& model, int joint, int speed) {
  for (const Coupling& coupling : model.couplings) {
    for (const CouplingTerm& term : coupling.terms) {
      if (term.joint == joint && first_u(*model.joints[joint].type, term.word) + term.component == speed) return true;
    }
  }
  return false;
}

/// Whether a driver, a spring or a coupling acts on a speed of a joint.
bool is_forced(const Model& model, int k, int speed) {
  const Joint& joint = model.joints[k];
  const auto acts = [&](const auto& one) { return first_u(*joint.type, one.word) + one.component == speed; };
  return std::any_of(joint.drivers.begin(), joint.drivers.end(), acts) ||
         std::any_of(joint.springs.begin(), joint.springs.end(), acts) || is_coupled(model, k, speed);
}

}  // namespace

struct SimbodyMachine::Parts {
  explicit Parts(const Model& stated);

  Evaluation evaluate(const State& state, const KnownForces& forces);

 private:
  void check_expressible() const;
  void check_parts(const std::vector<int>& parts) const;
  void build_bystander();
  void build();
  void build_step(const Step& step, const std::vector<int>& parts);
  void build_joint(BuiltJoint& built, const SimTK::Body& body, int k);
  void build_beside(BuiltJoint& built);
  void build_driver(int k, const Driver& driver);
  void build_coupling(const Coupling& coupling);

  /// The mobility of the speed that a word's coordinate has.
  [[nodiscard]] const Mobility& mobility_of(int k, int word, int component) const;
  [[nodiscard]] const MobilizedBody& mobod(MobilizedBodyIndex k) const { return matter_.getMobilizedBody(k); }

  // In one state:
  void place(const State& given);
  void place_link(const BuiltJoint& built, const Transform& X_FM, double turn);
  void set_in_motion(const State& given);
  void move_link(const BuiltJoint& built, const SpatialVec& velocity);
  [[nodiscard]] Transform relative_place(const Frames& frames, const Transform& parent, const Transform& child) const;
  [[nodiscard]] SpatialVec relative_velocity(const Frames& frames, const BodyState& parent,
                                             const BodyState& child) const;
  void check_places(const State& given) const;
  void apply(const State& given, const KnownForces& forces);
  void read(const State& given, Evaluation& found);
  [[nodiscard]] JointWrenches read_joint(const BuiltJoint& built, const State& given) const;
  [[nodiscard]] Vec6 coordinate_wrench(const BuiltJoint& built, const VecX& tau) const;
  [[nodiscard]] VecX forces_on_mobilities(const BuiltJoint& built) const;
  [[nodiscard]] Wrench total_on_child(const BuiltJoint& built) const;
  [[nodiscard]] Vec6 direction(const BuiltJoint& built, const Mobility& mobility) const;

  [[nodiscard]] Transform place_of(const BodyState& body) const {
    return {to_simbody(rotation_of_state(body)), units_.place(body.r)};
  }
  [[nodiscard]] SpatialVec velocity_of(const BodyState& body) const {
    return {to_simbody(body.omega), units_.place(body.v)};
  }
  [[nodiscard]] Wrench wrench_of(const SpatialVec& in_own_units) const {
    return {from_simbody(in_own_units[1]) * units_.force(), from_simbody(in_own_units[0]) * units_.torque()};
  }

  const Model& model_;
  Units units_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  SimTK::Force::Gravity gravity_;
  SimTK::Force::DiscreteForces known_{forces_, matter_};
  std::vector<MobilizedBodyIndex> bodies_;  // the main part of each
  std::vector<BuiltJoint> joints_;
  std::vector<Carrier> carriers_;
  std::vector<BuiltDriver> drivers_;
  std::vector<SimTK::ConstraintIndex> couplings_;
  SimTK::State state_;
  SimTK::Vector_<SpatialVec> reactions_;
};

SimbodyMachine::Parts::Parts(const Model& stated)
    : model_(stated), units_(units_of(stated)), gravity_(forces_, matter_, units_.place(stated.gravity)) {
  check_expressible();
  build();
  state_ = system_.realizeTopology();
  system_.realizeModel(state_);
}

void SimbodyMachine::Parts::check_expressible() const {
  for (const Body& body : model_.bodies) {
    if (body.n_modes() > 0) throw NotExpressible(fmt::format("body {} is flexible", body.name));
    if (body.modal) throw NotExpressible(fmt::format("body {} is given by mass points", body.name));
  }
  for (const Joint& joint : model_.joints) {
    if (find_recipe(joint.type->name) != nullptr) continue;
    throw NotExpressible(
        fmt::format("joint {} is of type {}, for which there is no mobilizer", joint.name, joint.type->name));
  }
}

void SimbodyMachine::Parts::build() {
  const std::vector<Step> plan = plan_of(model_);
  const std::vector<int> parts = parts_of(model_, plan);
  check_parts(parts);
  bodies_.resize(model_.bodies.size());
  bodies_[kGround] = matter_.getGround().getMobilizedBodyIndex();
  joints_.resize(model_.joints.size());
  for (const Step& step : plan) build_step(step, parts);
  for (std::size_t k = 0; k < model_.joints.size(); ++k) {
    for (const Driver& driver : model_.joints[k].drivers) build_driver(static_cast<int>(k), driver);
  }
  for (const Coupling& coupling : model_.couplings) build_coupling(coupling);
  build_bystander();
}

/// A part that hangs on a ball turns about every axis before it is welded: Simbody divides by its least inertia.
void SimbodyMachine::Parts::check_parts(const std::vector<int>& parts) const {
  for (std::size_t k = 1; k < parts.size(); ++k) {
    const Body& body = model_.bodies[k];
    const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(body.inertia_L, Eigen::EigenvaluesOnly).eigenvalues();
    if (parts[k] == 1 || moments(0) > kThinnest * moments(2)) continue;
    throw NotExpressible(
        fmt::format("body {} has next to no inertia about one of its axes, and {} joints hold it: it cannot be split",
                    body.name, parts[k]));
  }
}

/// Simbody divides by the size of its constraints, which is zero where all of them are idle: two welds side by side. A
/// body beside the machine, at rest and held there by one constraint, keeps it from zero.
void SimbodyMachine::Parts::build_bystander() {
  const MobilizedBodyIndex beside =
      add<MobilizedBody::Pin>(matter_.updGround(), Transform(), part_of_ground(), Transform());
  gravity_.setDefaultBodyIsExcluded(beside, true);
  SimTK::Constraint::ConstantAcceleration(matter_.updMobilizedBody(beside), 0.0);
}

void SimbodyMachine::Parts::build_step(const Step& step, const std::vector<int>& parts) {
  const SimTK::Body::Rigid body =
      step.body == kGround ? part_of_ground() : part_of(model_.bodies[step.body], parts[step.body], units_);
  if (step.joint < 0) {
    bodies_[step.body] = add<MobilizedBody::Free>(matter_.updGround(), Transform(), body, Transform());
    carriers_.push_back({step.body, bodies_[step.body]});
    return;
  }
  BuiltJoint& built = joints_[step.joint];
  build_joint(built, body, step.joint);
  if (step.is_main) {
    bodies_[step.body] = built.child;
    return;
  }
  SimTK::Constraint::Weld(matter_.updMobilizedBody(bodies_[step.body]), matter_.updMobilizedBody(built.child));
  if (step.body == kGround) gravity_.setDefaultBodyIsExcluded(built.child, true);
}

void SimbodyMachine::Parts::build_joint(BuiltJoint& built, const SimTK::Body& body, int k) {
  const Joint& joint = model_.joints[k];
  built.joint = &joint;
  built.recipe = find_recipe(joint.type->name);
  built.parent = bodies_[joint.on(Side::parent).body];
  for (const Mobility& mobility : built.recipe->mobilities) {
    built.is_forced.push_back(is_forced(model_, k, mobility.speed));
  }
  const auto frame_on = [&](Side side) {
    const Attachment& at = joint.on(side);
    return Transform(to_simbody(reordered(at.C, built.recipe->axes)), units_.place(at.point_L));
  };
  const auto attach = [&](const SimTK::Body& moved, const Transform& on_moved) {
    return add_mobilizer(*built.recipe, *joint.type, matter_.updMobilizedBody(built.parent), frame_on(Side::parent),
                         moved, on_moved, units_);
  };
  if (!built.has_link()) {
    built.moved = built.child = attach(body, frame_on(Side::child));
    build_beside(built);
    return;
  }
  built.moved = attach(SimTK::Body::Massless(), Transform());
  SimTK::Vec3 end(0);
  end[built.recipe->link] = length_of_link(*joint.type) / units_.length;
  built.child =
      add<MobilizedBody::Ball>(matter_.updMobilizedBody(built.moved), Transform(end), body, frame_on(Side::child));
}

void SimbodyMachine::Parts::build_beside(BuiltJoint& built) {
  const Attachment& on_child = built.joint->on(Side::child);
  const Attachment& on_parent = built.joint->on(Side::parent);
  MobilizedBody& child = matter_.updMobilizedBody(built.child);
  MobilizedBody& parent = matter_.updMobilizedBody(built.parent);
  if (built.recipe->beside == Beside::edge) {
    const SimTK::Constraint::NoSlip1D edge(child, units_.place(on_child.point_L),
                                           SimTK::UnitVec3(to_simbody(Vec3(on_child.C.col(1)))), parent, child);
    built.beside.push_back(edge.getConstraintIndex());
  }
  if (built.recipe->beside == Beside::rolling) {
    const double radius = radius_of(*built.joint->type);
    const Transform plane(to_simbody(on_parent.C), units_.place(on_parent.point_L - radius * on_parent.C.col(2)));
    const SimTK::Constraint::SphereOnPlaneContact contact(parent, plane, child, units_.place(on_child.point_L),
                                                          radius / units_.length, true);
    built.beside.push_back(contact.getConstraintIndex());
  }
}

const Mobility& SimbodyMachine::Parts::mobility_of(int k, int word, int component) const {
  const int speed = first_u(*model_.joints[k].type, word) + component;
  for (const Mobility& mobility : joints_[k].recipe->mobilities) {
    if (mobility.speed == speed) return mobility;
  }
  throw std::logic_error(fmt::format("joint {}: speed {} has no mobility", model_.joints[k].name, speed));
}

void SimbodyMachine::Parts::build_driver(int k, const Driver& driver) {
  const Mobility& mobility = mobility_of(k, driver.word, driver.component);
  const SimTK::Constraint::ConstantAcceleration constraint(matter_.updMobilizedBody(joints_[k].moved),
                                                           MobilizerUIndex(mobility.number), 0.0);
  drivers_.push_back({&driver, mobility.slides, constraint.getConstraintIndex()});
}

void SimbodyMachine::Parts::build_coupling(const Coupling& coupling) {
  const int n = static_cast<int>(coupling.terms.size());
  SimTK::Vector factors(n + 1, 0.0);  // the last one stands alone
  SimTK::Array_<MobilizedBodyIndex> bodies;
  SimTK::Array_<MobilizerUIndex> speeds;
  for (int k = 0; k < n; ++k) {
    const CouplingTerm& term = coupling.terms[k];
    const Mobility& mobility = mobility_of(term.joint, term.word, term.component);
    factors[k] = term.factor * units_.torque() / units_.of(mobility);
    bodies.push_back(joints_[term.joint].moved);
    speeds.push_back(MobilizerUIndex(mobility.number));
  }
  const SimTK::Constraint::SpeedCoupler coupler(matter_, new SimTK::Function::Linear(factors), bodies, speeds);
  couplings_.push_back(coupler.getConstraintIndex());
}

/// From the joint's frame on the parent to its frame on the child, whose mobilizers are `from` and `to`.
Transform SimbodyMachine::Parts::relative_place(const Frames& frames, const Transform& parent,
                                                const Transform& child) const {
  return ~(parent * mobod(frames.from).getDefaultInboardFrame()) * (child * mobod(frames.to).getDefaultOutboardFrame());
}

/// The rate of relative_place() in the frame on the parent: angular velocity, and that of the point.
SpatialVec SimbodyMachine::Parts::relative_velocity(const Frames& frames, const BodyState& parent,
                                                    const BodyState& child) const {
  const Transform X_GP = place_of(parent);
  const Transform X_GB = place_of(child);
  const Transform X_GF = X_GP * mobod(frames.from).getDefaultInboardFrame();
  const Transform X_GM = X_GB * mobod(frames.to).getDefaultOutboardFrame();
  const SpatialVec V_P = velocity_of(parent);
  const SpatialVec V_B = velocity_of(child);
  // The point of the child as seen from the parent, wherever on the parent it stands.
  const SimTK::Vec3 passing = V_P[1] + V_P[0] % (X_GM.p() - X_GP.p());
  const SimTK::Vec3 v_M = V_B[1] + V_B[0] % (X_GM.p() - X_GB.p());
  return {~X_GF.R() * (V_B[0] - V_P[0]), ~X_GF.R() * (v_M - passing)};
}

void SimbodyMachine::Parts::place(const State& given) {
  for (const Carrier& carrier : carriers_) {
    mobod(carrier.moved).setQToFitTransform(state_, place_of(given.bodies[carrier.body]));
  }
  for (const BuiltJoint& built : joints_) {
    const Transform X_FM = relative_place(built.frames(), place_of(given.bodies[built.body_on(Side::parent)]),
                                          place_of(given.bodies[built.body_on(Side::child)]));
    const MobilizedBody& moved = mobod(built.moved);
    if (built.has_link()) {
      const int k = static_cast<int>(&built - joints_.data());
      const bool has_hint = !given.q.empty() && given.q[k].size() > 1;
      place_link(built, X_FM, has_hint ? given.q[k](1) : 0.0);
    } else if (built.recipe->mobilizer == Mobilizer::screw) {
      moved.setOneQ(state_, 0, turn_of_screw(X_FM, lead_of(*built.joint->type) / units_.length));
    } else {
      moved.setQToFitTransform(state_, X_FM);
    }
  }
  system_.realize(state_, SimTK::Stage::Position);
}

/// Turns a link so that it points to the child's point, and then the ball at its end. `turn`: the link's second turn
/// roughly, because two pairs of turns of a universal joint point along the same line.
void SimbodyMachine::Parts::place_link(const BuiltJoint& built, const Transform& X_FM, double turn) {
  const MobilizedBody& link = mobod(built.moved);
  const SimTK::Vec3& gap = X_FM.p();
  SimTK::Rotation R_FL;
  if (built.recipe->mobilizer == Mobilizer::pin) {
    link.setOneQ(state_, 0, std::atan2(gap[1], gap[0]));
    R_FL.setRotationFromAngleAboutZ(link.getOneQ(state_, 0));
  } else {
    const double side = std::cos(turn) < 0.0 ? -1.0 : 1.0;
    link.setOneQ(state_, 0, std::atan2(-side * gap[1], side * gap[2]));
    link.setOneQ(state_, 1, std::atan2(gap[0], side * std::hypot(gap[1], gap[2])));
    R_FL.setRotationFromTwoAnglesTwoAxes(SimTK::BodyRotationSequence, link.getOneQ(state_, 0), SimTK::XAxis,
                                         link.getOneQ(state_, 1), SimTK::YAxis);
  }
  mobod(built.child).setQToFitRotation(state_, ~R_FL * X_FM.R());
}

void SimbodyMachine::Parts::set_in_motion(const State& given) {
  for (const Carrier& carrier : carriers_) {
    const SpatialVec velocity =
        relative_velocity({carrier.moved, carrier.moved}, given.bodies[kGround], given.bodies[carrier.body]);
    mobod(carrier.moved).setUToFitVelocity(state_, velocity);
  }
  for (const BuiltJoint& built : joints_) {
    const SpatialVec velocity = relative_velocity(built.frames(), given.bodies[built.body_on(Side::parent)],
                                                  given.bodies[built.body_on(Side::child)]);
    system_.realize(state_, SimTK::Stage::Position);  // setting speeds takes places back
    if (built.has_link()) {
      move_link(built, velocity);
    } else if (built.recipe->mobilizer == Mobilizer::screw) {
      mobod(built.moved).setUToFitAngularVelocity(state_, velocity[0]);
    } else {
      mobod(built.moved).setUToFitVelocity(state_, velocity);
    }
  }
}

/// The turning speeds of a link, and then those of the ball at its end, so that the child moves with `velocity` in the
/// frame on the parent.
void SimbodyMachine::Parts::move_link(const BuiltJoint& built, const SpatialVec& velocity) {
  const MobilizedBody& link = mobod(built.moved);
  const SimTK::Rotation R_FL = link.getMobilizerTransform(state_).R();
  const Vec3 end = from_simbody(R_FL * mobod(built.child).getDefaultInboardFrame().p());
  const auto n = static_cast<Eigen::Index>(built.recipe->mobilities.size());
  Mat3X axes(3, n);
  Mat3X levers(3, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    axes.col(k) = from_simbody(link.getH_FMCol(state_, MobilizerUIndex(built.recipe->mobilities[k].number))[0]);
    levers.col(k) = axes.col(k).cross(end);
  }
  const VecX speeds = (levers.transpose() * levers).ldlt().solve(levers.transpose() * from_simbody(velocity[1]));
  for (Eigen::Index k = 0; k < n; ++k) link.setOneU(state_, built.recipe->mobilities[k].number, speeds(k));
  system_.realize(state_, SimTK::Stage::Position);
  mobod(built.child).setUToFitAngularVelocity(state_, ~R_FL * (velocity[0] - to_simbody(Vec3(axes * speeds))));
}

void SimbodyMachine::Parts::check_places(const State& given) const {
  const auto check = [&](MobilizedBodyIndex part, int body) {
    const Transform is = mobod(part).getBodyTransform(state_);
    const Transform should_be = place_of(given.bodies[body]);
    const double off = (is.p() - should_be.p()).norm();
    const double turned = (is.R().asMat33() - should_be.R().asMat33()).norm();
    const double size = 1.0 + should_be.p().norm();
    if (off <= kMisplaced * size && turned <= kMisplaced) return;
    throw SolverError(
        fmt::format("simbody: t = {:g} s: the mobilizers leave body {} {:.1e} lengths and {:.1e} rad from "
                    "its place",
                    given.t, model_.bodies[body].name, off, turned));
  };
  for (const BuiltJoint& built : joints_) check(built.child, built.joint->on(Side::child).body);
}

void SimbodyMachine::Parts::apply(const State& given, const KnownForces& forces) {
  known_.clearAllForces(state_);
  for (std::size_t k = 1; k < model_.bodies.size(); ++k) {
    const Wrench& wrench = forces.on_bodies[k];
    known_.setOneBodyForce(
        state_, mobod(bodies_[k]),
        {to_simbody(Vec3(wrench.torque / units_.torque())), to_simbody(Vec3(wrench.force / units_.force()))});
  }
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    for (const Mobility& mobility : joints_[k].recipe->mobilities) {
      const double tau = forces.on_speeds[k](mobility.speed) / units_.of(mobility);
      if (tau == 0.0) continue;
      known_.setOneMobilityForce(state_, mobod(joints_[k].moved), MobilizerUIndex(mobility.number), tau);
    }
  }
  for (const BuiltDriver& driver : drivers_) {
    const SimTK::Constraint& constraint = matter_.getConstraint(driver.constraint);
    SimTK::Constraint::ConstantAcceleration::downcast(constraint)
        .setAcceleration(state_,
                         concord::evaluate(driver.driver->law, given.t).fddot / (driver.slides ? units_.length : 1.0));
  }
}

/// Column of the relative velocity [of the child's point; angular] that a mobility causes, global axes.
Vec6 SimbodyMachine::Parts::direction(const BuiltJoint& built, const Mobility& mobility) const {
  const MobilizedBody& moved = mobod(built.moved);
  const SimTK::Rotation R_GF = mobod(built.parent).getBodyRotation(state_) * moved.getDefaultInboardFrame().R();
  const SpatialVec column = moved.getH_FMCol(state_, MobilizerUIndex(mobility.number));
  SimTK::Vec3 velocity = R_GF * column[1];
  const SimTK::Vec3 turning = R_GF * column[0];
  if (built.has_link()) {
    const MobilizedBody& child = mobod(built.child);
    velocity += turning % (child.findStationLocationInGround(state_, child.getDefaultOutboardFrame().p()) -
                           moved.getBodyOriginLocation(state_));
  }
  Vec6 both;
  both << from_simbody(velocity) * (mobility.slides ? 1.0 : units_.length), from_simbody(turning);
  return both;
}

Wrench SimbodyMachine::Parts::total_on_child(const BuiltJoint& built) const {
  Wrench total = wrench_of(reactions_[built.child]);
  const MobilizedBody& child = mobod(built.child);
  const Vec3 arm = from_simbody(child.getBodyRotation(state_) * child.getDefaultOutboardFrame().p()) * units_.length;
  for (const SimTK::ConstraintIndex index : built.beside) {
    const SimTK::Constraint& constraint = matter_.getConstraint(index);
    const SimTK::Vector_<SpatialVec> forces = constraint.getConstrainedBodyForcesAsVector(state_);
    for (SimTK::ConstrainedBodyIndex k(0); k < constraint.getNumConstrainedBodies(); ++k) {
      if (constraint.getMobilizedBodyFromConstrainedBody(k).getMobilizedBodyIndex() != built.child) continue;
      const SpatialVec opposite = -forces[k];  // Simbody's constraint forces stand on the left of its equations
      total += shifted(wrench_of(opposite), -arm);
    }
  }
  return total;
}

/// Of the total wrench on the child, the part that the forces tau on the mobilities make up: in the span of the
/// directions along which they act, and S^T of it is tau. Forces that act on no mobility are none.
Vec6 SimbodyMachine::Parts::coordinate_wrench(const BuiltJoint& built, const VecX& tau) const {
  const Eigen::Index n = tau.size();
  if (n == 0) return Vec6::Zero();
  MatX S(6, n);
  MatX acting = MatX::Zero(6, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Mobility& mobility = built.recipe->mobilities[k];
    S.col(k) = direction(built, mobility);
    if (mobility.slides || built.has_link()) {
      acting.col(k).head<3>() = S.col(k).head<3>();
    } else {
      acting.col(k).tail<3>() = S.col(k).tail<3>();
    }
  }
  return acting * (S.transpose() * acting).partialPivLu().solve(tau);
}

/// Forces on the recipe's mobilities: what moves in a mobilizer is part of Simbody's reaction there.
VecX SimbodyMachine::Parts::forces_on_mobilities(const BuiltJoint& built) const {
  const auto n = static_cast<Eigen::Index>(built.recipe->mobilities.size());
  const SimTK::Rotation R_GF =
      mobod(built.parent).getBodyRotation(state_) * mobod(built.moved).getDefaultInboardFrame().R();
  const SpatialVec& reaction = reactions_[built.moved];
  VecX tau = VecX::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    if (!built.is_forced[k]) continue;
    const SpatialVec column =
        mobod(built.moved).getH_FMCol(state_, MobilizerUIndex(built.recipe->mobilities[k].number));
    tau(k) = units_.of(built.recipe->mobilities[k]) *
             (SimTK::dot(R_GF * column[0], reaction[0]) + SimTK::dot(R_GF * column[1], reaction[1]));
  }
  return tau;
}

JointWrenches SimbodyMachine::Parts::read_joint(const BuiltJoint& built, const State& given) const {
  const Joint& joint = *built.joint;
  const Wrench total = total_on_child(built);
  const VecX tau = forces_on_mobilities(built);
  const Vec6 known = coordinate_wrench(built, tau);
  Wrench reaction = total;
  reaction += {-known.head<3>(), -known.tail<3>()};
  JointWrenches found;
  found.tau = VecX::Zero(joint.type->n_u());
  for (Eigen::Index k = 0; k < tau.size(); ++k) found.tau(built.recipe->mobilities[k].speed) = tau(k);
  std::array<Mat3, 2> A_joint;
  std::array<Vec3, 2> point;
  for (const Side side : kSides) {
    const Attachment& at = joint.on(side);
    const Mat3 A = rotation_of_state(given.bodies[at.body]);
    A_joint[index(side)] = A * at.C;
    point[index(side)] = given.bodies[at.body].r + A * at.point_L;
  }
  const auto write = [&](const Wrench& on_child, std::array<SideWrench, 2>& both) {
    const Wrench opposite{-on_child.force, -on_child.torque};
    both[index(Side::child)] = in_both_frames(on_child, A_joint[index(Side::child)]);
    both[index(Side::parent)] = in_both_frames(
        shifted(opposite, point[index(Side::child)] - point[index(Side::parent)]), A_joint[index(Side::parent)]);
  };
  write(total, found.total);
  write(reaction, found.reaction);
  return found;
}

void SimbodyMachine::Parts::read(const State& given, Evaluation& found) {
  matter_.calcMobilizerReactionForces(state_, reactions_);
  found.bodies.resize(model_.bodies.size());
  for (std::size_t k = 1; k < bodies_.size(); ++k) {
    found.bodies[k].vdot = from_simbody(mobod(bodies_[k]).getBodyOriginAcceleration(state_)) * units_.length;
    found.bodies[k].omegadot = from_simbody(mobod(bodies_[k]).getBodyAngularAcceleration(state_));
    if (found.bodies[k].vdot.allFinite() && found.bodies[k].omegadot.allFinite()) continue;
    throw SolverError(
        fmt::format("simbody: t = {:g} s: the acceleration of body {} is not finite", given.t, model_.bodies[k].name));
  }
  for (const BuiltJoint& built : joints_) found.joints.push_back(read_joint(built, given));
  for (const SimTK::ConstraintIndex index : couplings_) {
    // A multiplier stands on the left of Simbody's equations: it pushes the sum to fall.
    found.couplings.push_back(-units_.torque() * matter_.getConstraint(index).getMultipliersAsVector(state_)[0]);
  }
}

Evaluation SimbodyMachine::Parts::evaluate(const State& state, const KnownForces& forces) {
  Evaluation found;
  try {
    place(state);
    set_in_motion(state);
    apply(state, forces);
    system_.realize(state_, SimTK::Stage::Position);
    check_places(state);
    system_.realize(state_, SimTK::Stage::Acceleration);
    read(state, found);
  } catch (const SimTK::Exception::Base& error) {
    throw SolverError(fmt::format("simbody: t = {:g} s: {}", state.t, in_one_line(error.what())));
  }
  return found;
}

SimbodyMachine::SimbodyMachine(const Model& model) {
  try {
    parts_ = std::make_unique<Parts>(model);
  } catch (const SimTK::Exception::Base& error) {
    throw NotExpressible(in_one_line(error.what()));
  }
}

SimbodyMachine::~SimbodyMachine() = default;

Evaluation SimbodyMachine::evaluate(const State& state, const KnownForces& forces) {
  return parts_->evaluate(state, forces);
}

}  // namespace concord::compare::oracle
