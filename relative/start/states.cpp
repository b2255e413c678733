#include "relative/start/states.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "relative/bodies/exponential_map.h"

namespace concord::relative {

namespace {

/// The larger of a displacement and a rotation, each relative to its size.
double largest(const Vec6& values, double linear_size, double angular_size) {
  const double linear = values.head<3>().cwiseAbs().maxCoeff();
  const double angular = values.tail<3>().cwiseAbs().maxCoeff();
  return std::isnan(linear + angular) ? linear + angular : std::max(linear / linear_size, angular / angular_size);
}

constexpr double kLargestMisfit = 1e-12;
constexpr double kRoundOffOfTurns = 4.0 * std::numeric_limits<double>::epsilon();

void require_numbers(const BodyState& body, const std::string& name, double t) {
  if (body.r.allFinite() && body.p.allFinite() && body.v.allFinite() && body.omega.allFinite() && body.a.allFinite() &&
      body.adot.allFinite()) {
    return;
  }
  throw SolverError(
      fmt::format("relative: the state at t = {:.6g} s holds a number of body '{}' that is not finite", t, name));
}

}  // namespace

void StateMisfit::take(double value, const char* kind, const std::string& name) {
  if (std::isnan(largest) || value <= largest) return;
  largest = value;
  where = fmt::format("{} '{}'", kind, name);
}

States::States(const Equations& equations) : equations_(&equations), kinematics_(equations.model()) {
  for (const JointIndex k : upward<JointIndex>(equations.model().joints.size())) {
    measures_.emplace_back(kinematics_.mobilizer(k),
                           equations.driven().data() + equations.topology().joints[k].first_u);
    nonholonomic_.emplace_back(*equations.model().joints[k].type, kinematics_.mobilizer(k));
  }
}

void States::require_shape(const State& state) const {
  const Model& model = equations_->model();
  if (state.bodies.size() != model.bodies.size()) {
    throw SolverError(fmt::format("relative: the state has {} bodies, the model {} (ground included)",
                                  state.bodies.size(), model.bodies.size()));
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const int m = model.bodies[i].n_modes();
    if (state.bodies[i].a.size() == m && state.bodies[i].adot.size() == m) continue;
    throw SolverError(
        fmt::format("relative: the state has {} modal coordinates and {} rates for body '{}', which has "
                    "{} modes",
                    state.bodies[i].a.size(), state.bodies[i].adot.size(), model.bodies[i].name, m));
  }
}

/// The size of angles of a joint [rad]: 1, or where it has made so many turns that their round-off is more than
/// kLargestMisfit of that, as much more.
double States::angle_size(const Span& span) const {
  if (span.n_q == 0) return 1.0;
  const double turned = kWholeTurn * kinematics_.turns().segment(span.first_q, span.n_q).cwiseAbs().maxCoeff();
  return std::max(1.0, kRoundOffOfTurns / kLargestMisfit * turned);
}

/// Places the bodies, and measures all joints from what the state brings of them.
Coordinates States::measure_joints(const State& state, JointMeasure::Restart restart) {
  require_shape(state);
  const Model& model = equations_->model();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    require_numbers(state.bodies[i], model.bodies[i].name, state.t);
  }
  Coordinates found = stated_coordinates(state);
  count_turns(found);
  kinematics_.place(state.bodies);
  for (const JointIndex k : upward<JointIndex>(model.joints.size())) {
    measure_joint(k, has_q(state, k) ? restart : JointMeasure::Restart::if_better, found);
  }
  return found;
}

Coordinates States::read_beside(const State& state) { return measure_joints(state, JointMeasure::Restart::never); }

Coordinates States::read(const State& state, StateMisfit& misfit) {
  Coordinates found = measure_joints(state, JointMeasure::Restart::if_clearly_better);
  const Model& model = equations_->model();
  misfit = {};
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    misfit.take(std::abs(state.bodies[i].p.norm() - 1.0), "body", model.bodies[i].name);
  }
  const MachineSize& size = kinematics_.size();
  const Sizes sizes{std::max(size.length(), kinematics_.farthest_place()), size.rate_at(found.u)};
  for (const JointIndex k : upward<JointIndex>(model.joints.size())) take_misfit(k, sizes, found, misfit);
  misfit.joint_off_branch = joint_off_branch(state, found.q);
  for (const Coupling& coupling : model.couplings) measure_coupling(coupling, sizes, found, misfit);
  return found;
}

/// What a state says itself: the modal coordinates of its bodies, and the coordinates of joints where it brings them.
Coordinates States::stated_coordinates(const State& state) const {
  const Topology& topology = equations_->topology();
  Coordinates found{state.t, equations_->home(), VecX::Zero(topology.n_u)};
  for (std::size_t i = 1; i < state.bodies.size(); ++i) {
    const BodyState& body = state.bodies[i];
    found.q.segment(topology.modes[i].first_q, topology.modes[i].n_q) = body.a;
    found.u.segment(topology.modes[i].first_u, topology.modes[i].n_u) = body.adot;
  }
  for (const JointIndex k : upward<JointIndex>(topology.joints.size())) {
    const Span& span = topology.joints[k];
    if (has_q(state, k)) found.q.segment(span.first_q, span.n_q) = state.q[k];
  }
  return found;
}

/// Coordinates and speeds of a joint between its bodies, which have been placed.
void States::measure_joint(JointIndex k, JointMeasure::Restart restart, Coordinates& found) {
  const Span& span = equations_->topology().joints[k];
  JointMeasure& measure = measures_[k];
  const JointPoint& parent = kinematics_.point(k, Side::parent);
  const JointPoint& child = kinematics_.point(k, Side::child);
  measure.find_q(parent, child, found.q.data() + span.first_q, restart);
  measure.find_u(parent, child, found.q.data() + span.first_q, found.u.data() + span.first_u);
  kinematics_.require_rank(k, measure.motion_at());
}

/// What is left of both.
void States::take_misfit(JointIndex k, const Sizes& sizes, const Coordinates& found, StateMisfit& misfit) {
  const std::string& name = equations_->model().joints[k].name;
  const JointMeasure& measure = measures_[k];
  const double angles = angle_size(equations_->topology().joints[k]);
  misfit.take(largest(measure.position_residual(), sizes.place, angles), "joint", name);
  // Round-off of places far from the origin stands between the points of a joint, and turns with them.
  misfit.take(largest(measure.velocity_residual(), sizes.rate * sizes.place, sizes.rate), "joint", name);
  misfit.take(nonholonomic_residual(k, found.u) / sizes.rate, "joint", name);
}

/// What is left of a coupling's two relations; after all joints have been measured.
void States::measure_coupling(const Coupling& coupling, const Sizes& sizes, const Coordinates& found,
                              StateMisfit& misfit) const {
  const Readings readings = size_of_readings(coupling);
  const double terms = size_of_terms(coupling, kinematics_, found.q);
  const double position_residual = compute_position_residual(coupling, kinematics_, found.q);
  const double velocity_residual =
      compute_velocity_residual(coupling, equations_->model(), equations_->topology(), found.u);
  const double of_turns = kRoundOffOfTurns / kLargestMisfit * size_of_turns(coupling, kinematics_);
  misfit.take(std::abs(position_residual) / std::max({readings.of_coordinates, terms, of_turns}), "coupling",
              coupling.name);
  misfit.take(std::abs(velocity_residual) / (readings.of_speeds * sizes.rate), "coupling", coupling.name);
}

Coordinates States::read_closed(const State& state) {
  StateMisfit misfit;
  Coordinates coordinates = read(state, misfit);
  if (!(misfit.largest <= kLargestMisfit)) {
    throw OpenState(fmt::format("relative: at t = {:.6g} s the state is not closed: residual {:.1e} at {}, allowed "
                                "{:.0e}: close it first",
                                state.t, misfit.largest, misfit.where, kLargestMisfit),
                    misfit.where);
  }
  if (misfit.joint_off_branch) throw_off_branch(state, coordinates, *misfit.joint_off_branch);
  return coordinates;
}

void States::throw_off_branch(const State& state, const Coordinates& coordinates, JointIndex joint) const {
  const Span& span = equations_->topology().joints[joint];
  const VecX found = kinematics_.with_turns(coordinates.q).segment(span.first_q, span.n_q);
  throw SolverError(fmt::format(
      "relative: at t = {:.6g} s joint '{}' stands on another turn or branch than its coordinates say: "
      "({:.6g}) from the poses of its bodies, ({:.6g}) with the state",
      state.t, equations_->model().joints[joint].name, fmt::join(found, ", "), fmt::join(state.q[joint], ", ")));
}

/// Whole turns of the coordinates that came with a state, driven ones by their laws, are counted apart from now on.
void States::count_turns(Coordinates& coordinates) {
  kinematics_.count_turns(VecX::Zero(coordinates.q.size()));
  equations_->prescribe(coordinates.t, kinematics_, coordinates.q, coordinates.u);
  kinematics_.count_turns(kinematics_.whole_turns(coordinates.q));
  coordinates.q = kinematics_.without_turns(coordinates.q);
}

bool States::has_q(const State& state, JointIndex joint) const {
  return joint < static_cast<int>(state.q.size()) && state.q[joint].size() == equations_->topology().joints[joint].n_q;
}

std::optional<JointIndex> States::joint_off_branch(const State& state, const VecX& q) const {
  const VecX values = kinematics_.with_turns(q);
  for (const JointIndex k : upward<JointIndex>(measures_.size())) {
    if (!has_q(state, k)) continue;
    const double* found = values.data() + equations_->topology().joints[k].first_q;
    if (!equations_->kinematics().mobilizer(k).is_on_branch_of(found, state.q[k].data())) return k;
  }
  return std::nullopt;
}

/// The size of a coupling's factors [its unit], each as much larger as the round-off of the bodies' poses and
/// velocities is when it is read as its coordinate and its speed. Near a gimbal pose a coordinate takes that of the
/// poses times the amplification, and its speed this error's part of the other speeds, amplified once more. After the
/// joints have been measured.
States::Readings States::size_of_readings(const Coupling& coupling) const {
  const Model& model = equations_->model();
  double of_coordinates = 0.0;
  double of_speeds = 0.0;
  for (const CouplingTerm& term : coupling.terms) {
    const int c = first_u(*model.joints[term.joint].type, term.word) + term.component;
    const double unit = kinematics_.size().speeds()(kinematics_.topology().joints[term.joint].first_u + c);
    const double amplification = std::max(1.0, measures_[term.joint].amplification(c));
    of_coordinates = std::hypot(of_coordinates, term.factor * unit * amplification);
    of_speeds = std::hypot(of_speeds, term.factor * unit * amplification * amplification);
  }
  return {of_coordinates, of_speeds};
}

/// How far the speeds of a joint are from those that its type permits [rad/s]; after its coordinates and speeds have
/// been measured.
double States::nonholonomic_residual(JointIndex joint, const VecX& u) {
  NonholonomicConstraint& permitted = nonholonomic_[joint];
  if (permitted.n_rows() == 0) return 0.0;
  permitted.evaluate(measures_[joint].motion_at(), equations_->model().joints[joint].name);
  const Span& span = equations_->topology().joints[joint];
  const VecX velocity_residual = permitted.C().transpose() * u.segment(span.first_u, span.n_u);
  return velocity_residual.cwiseAbs().maxCoeff();
}

State States::write(const Motion& motion, const State& before) const {
  const Model& model = equations_->model();
  const Topology& topology = equations_->topology();
  State state;
  state.t = motion.t();
  state.bodies.resize(model.bodies.size());
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const BodyMotion moved = equations_->kinematics().motion_of_origin(BodyIndex(i));
    const Vec4 near = before.bodies.empty() ? Vec4(Vec4::Unit(0)) : before.bodies[i].p;
    BodyState& body = state.bodies[i];
    body.r = moved.r;
    body.p = euler_parameters(moved.A, near);
    body.v = moved.v;
    body.omega = moved.omega;
    body.a = motion.q().segment(topology.modes[i].first_q, topology.modes[i].n_q);
    body.adot = motion.u().segment(topology.modes[i].first_u, topology.modes[i].n_u);
  }
  const VecX q = equations_->kinematics().with_turns(motion.q());
  for (const Span& span : topology.joints) {
    state.q.emplace_back(q.segment(span.first_q, span.n_q));
    state.u.emplace_back(motion.u().segment(span.first_u, span.n_u));
  }
  state.spring_angles = equations_->applied_forces().spring_angles(motion);
  return state;
}

Evaluation States::write_accelerations(const Evaluated& evaluated) const {
  Evaluation evaluation;
  for (const BodyIndex i : upward<BodyIndex>(equations_->model().bodies.size())) {
    evaluation.bodies.push_back(evaluated.acceleration(i));
  }
  return evaluation;
}

Evaluation States::write_evaluation(const Evaluated& evaluated, const JointReactions& reactions) const {
  Evaluation evaluation = write_accelerations(evaluated);
  evaluation.joints = reactions.joints;
  evaluation.elements = evaluated.applied_forces().elements();
  evaluation.couplings = reactions.couplings;
  return evaluation;
}

}  // namespace concord::relative
