// Compiled without NDEBUG and as C++17, as the library itself is: see CMakeLists.txt.
#include "compare/oracle/simbody_machine.h"

#include <Simbody.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "common/error.h"
#include "compare/oracle/plan.h"
#include "compare/oracle/recipes.h"
#include "compare/oracle/simbody_parts.h"
#include "compare/quantities/not_expressible.h"

namespace concord::compare::oracle {

namespace {

/// Least over largest moment of inertia of a body that is split: what is left of 16 digits is more than the need.
constexpr double kThinnest = 1e-6;

Units units_of(const Model& model) {
  Units units{model.length_scale(), 0.0};
  for (const Body& body : model.bodies) units.mass = std::max(units.mass, body.mass);
  if (!(units.mass > 0.0)) units.mass = 1.0;
  return units;
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
    if (joints::arm_of(word)) return joints::stated_length(word);
  }
  throw std::logic_error(type.name + " has no arm");
}

double radius_of(const joints::JointType& type) { return joints::stated_length(type.forbids_speeds.front()); }

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

double lead_of(const joints::JointType& type) {
  const double zero = 0.0;
  joints::FunctionOfCoordinates::Motion motion;
  joints::function_of(type.permits.front())->evaluate(&zero, &zero, motion);
  return motion.S(2, 0);
}

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
  [[maybe_unused]] const SimTK::Constraint::Weld weld(matter_.updMobilizedBody(bodies_[step.body]),
                                                      matter_.updMobilizedBody(built.child));
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
