#include "compare/audit/motion_audit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/audit/free_body.h"
#include "compare/audit/stated_derivatives.h"

namespace concord::compare {

namespace {

constexpr std::array kDirections{"along x", "along y", "along z", "about x", "about y", "about z"};

double mass_in(const Body& body) {
  if (!body.modal) return body.mass;
  double sum = 0.0;
  for (const MassPoint& point : body.modal->mass_points) sum += point.mass;
  return sum;
}

/// What of a residual its own uncertainty does not explain.
double beyond(double residual, double doubt) {
  return std::isnan(residual) ? residual : std::max(0.0, std::abs(residual) - doubt);
}

int driven_speed_of(const Joint& joint, const Driver& driver) {
  return first_u(*joint.type, driver.word) + driver.component;
}

}  // namespace

MotionAudit::MotionAudit(const Model& model) : model_(model), length_(model.length_scale()) {
  for (const Body& body : model.bodies) mass_ += mass_in(body);
  for (const Joint& joint : model.joints) lay_out(joint);
  for (const Coupling& coupling : model.couplings) {
    AuditEntity& entity = couplings_.emplace_back(AuditEntity{coupling.name, {}, false});
    for (const char* what : {"sum of coordinates", "sum of speeds", "sum of accelerations"}) {
      entity.rows.push_back({AuditRule::driver_law, what, AuditUnit::own});
    }
  }
  coupled_speeds_.resize(model.joints.size());
  for (const Coupling& coupling : model.couplings) {
    for (const CouplingTerm& term : coupling.terms) {
      const int u = first_u(*model.joints[term.joint].type, term.word) + term.component;
      coupled_speeds_[static_cast<std::size_t>(term.joint)].push_back(u);
    }
  }
  for (const Body& body : model.bodies) ways_.push_back(largest_ways(body, length_));
  kinematics_.resize(model.joints.size());
  scales_.resize(model.joints.size());
}

/// Rows in the order of add_joint().
void MotionAudit::lay_out(const Joint& joint) {
  AuditEntity& entity = joints_.emplace_back(AuditEntity{joint.name, {}, false});
  const auto add = [&](const char* what, AuditUnit (*unit)(bool)) {
    for (int k = 0; k < 6; ++k) {
      entity.rows.push_back({AuditRule::kinematics, fmt::format("{} {}", what, kDirections[k]), unit(k >= 3)});
    }
  };
  add("place", unit_of_position);
  add("velocity", unit_of_speed);
  add("acceleration", unit_of_acceleration);
  const std::vector<bool> turning = turning_speeds(*joint.type);
  const std::vector<std::string> names = speed_names(*joint.type);
  std::vector<LawOfTime>& laws = drivers_.emplace_back();
  for (const Driver& driver : joint.drivers) {
    laws.emplace_back(driver.law);
    const auto u = static_cast<std::size_t>(driven_speed_of(joint, driver));
    entity.rows.push_back({AuditRule::driver_law, names[u], unit_of_position(turning[u])});
    entity.rows.push_back({AuditRule::driver_law, "speed of " + names[u], unit_of_speed(turning[u])});
    entity.rows.push_back({AuditRule::driver_law, "acceleration of " + names[u], unit_of_acceleration(turning[u])});
  }
  for (const std::string& name : stated_derivatives(*joint.type)) {
    entity.rows.push_back({AuditRule::derivatives, name, AuditUnit::own});
  }
}

void MotionAudit::add(const State& state, const Evaluation& evaluation) {
  const LeastScales least = least_scales(state, evaluation);
  for (std::size_t k = 0; k < joints_.size(); ++k) add_joint(k, state, evaluation, least);
  for (std::size_t c = 0; c < couplings_.size(); ++c) add_coupling(c, state.t);
}

/// Of forces: what gravity does, and what the largest force would do to the machine's mass. A rotor whose places all
/// lie on its axis moves none of them, and a bearing at rest sees none of what it spins: they are held against a part
/// of the fastest body's rim, or of what its modes move fastest.
MotionAudit::LeastScales MotionAudit::least_scales(const State& state, const Evaluation& evaluation) const {
  constexpr double kPartOfFastest = 1e-6;
  LeastScales least;
  least.of_forces = std::max(model_.gravity.norm(), mass_ > 0.0 ? largest_force_in(model_, evaluation) / mass_ : 0.0);
  for (std::size_t i = 1; i < state.bodies.size(); ++i) {
    const double turn = state.bodies[i].omega.norm();
    const BodyAcceleration& rates = evaluation.bodies[i];
    const double modes_move = ways_[i].dot(state.bodies[i].adot.cwiseAbs());
    const double modes_accelerate = ways_[i].dot(rates.addot.cwiseAbs());
    least.speed = std::max({least.speed, length_ * turn, state.bodies[i].v.norm(), modes_move});
    least.acceleration = std::max(
        {least.acceleration, length_ * (turn * turn + rates.omegadot.norm()), rates.vdot.norm(), modes_accelerate});
  }
  least.speed *= kPartOfFastest;
  least.acceleration *= kPartOfFastest;
  return least;
}

/// Scales of a joint's rows: the sizes of the terms, at least what `least` gives along the length.
AuditScales MotionAudit::scales_of(const JointKinematics& found, const State& state, const Joint& joint,
                                   const LeastScales& least) const {
  const double until = model_.run.until;
  double reach = length_;
  for (const Attachment& side : joint.sides) reach = std::max(reach, state.bodies[side.body].r.norm());
  AuditScales scales{};
  scales[index(AuditUnit::length)] = reach;
  scales[index(AuditUnit::angle)] = 1.0;
  // A machine at rest that nothing moves has speeds that are round-off.
  constexpr double kSpeedOfRest = 1e-12;  // of the length in the time of the run
  const double speed =
      std::max({found.speed.line, std::sqrt(least.of_forces * length_), least.speed, kSpeedOfRest * reach / until});
  scales[index(AuditUnit::speed)] = speed;
  scales[index(AuditUnit::turning_speed)] = std::max(found.speed.turn, speed / length_);
  const double acceleration =
      std::max({found.rate_of_speed.line, least.of_forces, least.acceleration, kSpeedOfRest * reach / (until * until)});
  scales[index(AuditUnit::acceleration)] = acceleration;
  scales[index(AuditUnit::turning_acceleration)] = std::max(found.rate_of_speed.turn, acceleration / length_);
  return scales;
}

VecX MotionAudit::expected_udot(std::size_t joint, double t) const {
  const Joint& stated = model_.joints[joint];
  VecX expected = VecX::Constant(stated.type->n_u(), std::numeric_limits<double>::quiet_NaN());
  for (const int u : coupled_speeds_[joint]) expected(u) = std::numeric_limits<double>::infinity();
  for (std::size_t d = 0; d < stated.drivers.size(); ++d) {
    expected(driven_speed_of(stated, stated.drivers[d])) = drivers_[joint][d].at(t).rate_of_rate;
  }
  return expected;
}

void MotionAudit::add_joint(std::size_t k, const State& state, const Evaluation& evaluation, const LeastScales& least) {
  const Joint& joint = model_.joints[k];
  const VecX hint = k < state.q.size() ? state.q[k] : VecX();
  JointKinematics& found = kinematics_[k];
  found = read_kinematics(joint, state, evaluation, hint, expected_udot(k, state.t), length_);
  scales_[k] = scales_of(found, state, joint, least);

  std::vector<AuditRow>& rows = joints_[k].rows;
  std::size_t next = 0;
  const auto take = [&](double residual, double at_least, double doubt = 0.0) {
    AuditRow& row = rows[next++];
    row.take(beyond(residual, doubt), std::max(scales_[k][index(row.unit)], std::abs(at_least)), state.t);
  };
  for (const Vec6* misfit : {&found.place, &found.velocity}) {
    for (const double residual : *misfit) take(residual, 0.0);
  }
  for (int c = 0; c < 6; ++c) take(found.acceleration(c), 0.0, found.doubt_of_acceleration(c));
  for (std::size_t d = 0; d < joint.drivers.size(); ++d) {
    const Driver& driver = joint.drivers[d];
    const Moving law = drivers_[k][d].at(state.t);
    const int u = driven_speed_of(joint, driver);
    const int q = first_q(*joint.type, driver.word) + driver.component;
    take(found.motion.q(q) - law.value, law.value, found.doubt_of_q(q));
    take(found.motion.u(u) - law.rate, law.rate, found.doubt_of_u(u));
    take(found.udot(u) - law.rate_of_rate, law.rate_of_rate, found.doubt_of_udot(u));
  }
  if (next == rows.size()) return;
  for (const StatedDerivative& derivative :
       compute_stated_derivatives(*joint.type, found.relative, found.motion, length_)) {
    rows[next++].take(derivative.misfit, derivative.scale, state.t);
  }
}

/// Sum of factor q = offset, of factor u = 0 and of factor udot = 0, each against the sum of the sizes.
void MotionAudit::add_coupling(std::size_t c, double t) {
  const Coupling& coupling = model_.couplings[c];
  double place = -coupling.offset;
  double speed = 0.0;
  double acceleration = 0.0;
  std::array<double, 3> doubts{};
  std::array<double, 3> sizes{std::abs(coupling.offset), 0.0, 0.0};
  for (const CouplingTerm& term : coupling.terms) {
    const joints::JointType& type = *model_.joints[term.joint].type;
    const JointKinematics& found = kinematics_[term.joint];
    const AuditScales& scales = scales_[term.joint];
    const int u = first_u(type, term.word) + term.component;
    const bool turns = turning_speeds(type)[static_cast<std::size_t>(u)];
    const int place_of_q = first_q(type, term.word) + term.component;
    const double q = found.motion.q(place_of_q);
    place += term.factor * q;
    speed += term.factor * found.motion.u(u);
    acceleration += term.factor * found.udot(u);
    const double size = std::abs(term.factor);
    doubts[0] += size * found.doubt_of_q(place_of_q);
    doubts[1] += size * found.doubt_of_u(u);
    doubts[2] += size * found.doubt_of_udot(u);
    sizes[0] += size * std::max(std::abs(q), scales[index(unit_of_position(turns))]);
    sizes[1] += size * scales[index(unit_of_speed(turns))];
    sizes[2] += size * scales[index(unit_of_acceleration(turns))];
  }
  std::vector<AuditRow>& rows = couplings_[c].rows;
  rows[0].take(beyond(place, doubts[0]), sizes[0], t);
  rows[1].take(beyond(speed, doubts[1]), sizes[1], t);
  rows[2].take(beyond(acceleration, doubts[2]), sizes[2], t);
}

}  // namespace concord::compare
