#include "compare/audit/free_body.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/decompositions.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"

namespace concord::compare {

namespace {

/// A rigid body as six mass points with its mass, centre of mass and inertia: at plus and minus the half axes of its
/// ellipsoid of second moments tr(I)/2 1 - I.
std::vector<MassPoint> six_points(const Body& body) {
  if (body.mass <= 0.0) return {};
  const Mat3 second_moment = 0.5 * body.inertia_L.trace() * Mat3::Identity() - body.inertia_L;
  const SymmetricEigenpairs ellipsoid = symmetric_eigenpairs(second_moment);
  std::vector<MassPoint> points;
  for (int axis = 0; axis < 3; ++axis) {
    const double reach = std::sqrt(std::max(0.0, 3.0 * ellipsoid.values(axis) / body.mass));
    for (const double way : {-reach, reach}) {
      points.push_back({body.mass / 6.0, body.center_of_mass_L + way * ellipsoid.vectors.col(axis), Mat3X(3, 0)});
    }
  }
  return points;
}

/// Sum over the mass points of their forces m (acceleration - g), moments about the body's origin and, by virtual work,
/// modal rows; plus K a + D adot.
Balance inertia_and_stiffness(const Body& body, const std::vector<MassPoint>& points, const Vec3& gravity,
                              const BodyState& state, const BodyAcceleration& acceleration) {
  const int n_modes = body.n_modes();
  const Mat3 A = rotation_of(state.p);
  const Vec3& omega = state.omega;
  Balance balance(n_modes);
  VecX sizes = VecX::Zero(6 + n_modes);
  for (const MassPoint& point : points) {
    const Vec3 s = A * (point.s0_L + point.Psi_t_L * state.a);
    const Vec3 sdot = A * (point.Psi_t_L * state.adot);
    const Vec3 sddot = A * (point.Psi_t_L * acceleration.addot);
    const Vec3 point_acceleration = acceleration.vdot + acceleration.omegadot.cross(s) + omega.cross(omega.cross(s)) +
                                    2.0 * omega.cross(sdot) + sddot;
    const Vec3 force = point.mass * (point_acceleration - gravity);
    const double size = point.mass * (point_acceleration.norm() + gravity.norm());
    balance.rows.head<3>() += force;
    balance.rows.segment<3>(3) += s.cross(force);
    balance.rows.tail(n_modes) += point.Psi_t_L.transpose() * (A.transpose() * force);
    sizes.head<3>().array() += size;
    sizes.segment<3>(3).array() += s.norm() * size;
    sizes.tail(n_modes) += size * point.Psi_t_L.colwise().norm().transpose();
  }
  if (body.modal) {
    const VecX elastic = body.modal->stiffness * state.a;
    const VecX damping = body.modal->damping * state.adot;
    balance.rows.tail(n_modes) += elastic + damping;
    sizes.tail(n_modes) = sizes.tail(n_modes).cwiseMax(elastic.cwiseAbs()).cwiseMax(damping.cwiseAbs());
  }
  balance.raise_scales(sizes);
  return balance;
}

/// Takes away the generalized force of a wrench (global axes, at the deformed joint point), by its power (S20):
/// Q_r = F, Q_pi = T + (A s_P) x F, Q_a = Psi_t^T A^T F + (J Psi_r)^T A^T T.
void subtract_wrench(const Attachment& side, const BodyState& state, const Wrench& wrench, Balance& balance) {
  const auto n_modes = state.a.size();
  const Mat3 A = rotation_of(state.p);
  const PlacedFrame frame = place(side, state);
  const Vec3 force_L = A.transpose() * wrench.force;
  const Vec3 torque_L = A.transpose() * wrench.torque;
  const Mat3X J_Psi_r = exponential_rate(side.Psi_r_L * state.a) * side.Psi_r_L;
  balance.rows.head<3>() -= wrench.force;
  balance.rows.segment<3>(3) -= wrench.torque + frame.lever.cross(wrench.force);
  balance.rows.tail(n_modes) -= side.Psi_t_L.transpose() * force_L + J_Psi_r.transpose() * torque_L;
  VecX sizes(6 + n_modes);
  sizes.head<3>().setConstant(wrench.force.norm());
  sizes.segment<3>(3).setConstant(std::max(wrench.torque.norm(), frame.lever.norm() * wrench.force.norm()));
  sizes.tail(n_modes) = wrench.force.norm() * side.Psi_t_L.colwise().norm().transpose() +
                        wrench.torque.norm() * J_Psi_r.colwise().norm().transpose();
  balance.raise_scales(sizes);
}

}  // namespace

const std::vector<MassPoint>& mass_points_of(const Body& body, std::vector<MassPoint>& of_rigid) {
  if (body.modal) return body.modal->mass_points;
  of_rigid = six_points(body);
  return of_rigid;
}

double mass_of(const Body& body) { return body.modal ? body.modal->G(0, 0) : body.mass; }

VecX modal_masses(const ModalData& modal) {
  VecX masses(modal.n_modes());
  for (Eigen::Index m = 0; m < masses.size(); ++m) masses(m) = modal.G.diagonal().segment<3>(4 + 3 * m).sum();
  return masses;
}

VecX largest_displacements(const Body& body) {
  return body.modal ? concord::largest_displacements(*body.modal) : VecX(0);
}

VecX largest_ways(const Body& body, double length) {
  VecX largest = largest_displacements(body);
  if (!body.modal) return largest;
  for (const ModalNode& node : body.modal->nodes) {
    largest = largest.cwiseMax(node.Psi_t_L.colwise().norm().transpose());
    largest = largest.cwiseMax(length * node.Psi_r_L.colwise().norm().transpose());
  }
  return largest;
}

void Balance::raise_scales(const VecX& terms) { scales = scales.cwiseMax(terms); }

FreeBodies::FreeBodies(const Model& model)
    : model_(model), points_of_rigid_(model.bodies.size()), ends_(model.bodies.size()) {
  for (std::size_t i = 0; i < model.bodies.size(); ++i) mass_points_of(model.bodies[i], points_of_rigid_[i]);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : kSides) {
      const Attachment& place = model.joints[k].on(side);
      ends_[place.body].push_back({&place, side, k, true});
    }
  }
  for (std::size_t k = 0; k < model.elements.size(); ++k) {
    for (const Side side : kSides) {
      const Attachment* place = end_of(model.elements[k], side);
      if (place != nullptr) ends_[place->body].push_back({place, side, k, false});
    }
  }
}

const std::vector<MassPoint>& FreeBodies::points_of(int body) const {
  return model_.bodies[body].modal ? model_.bodies[body].modal->mass_points : points_of_rigid_[body];
}

const Wrench& FreeBodies::wrench_at(const End& end, const Evaluation& evaluation) {
  return end.is_of_joint ? evaluation.joints[end.owner].total_on(end.side).in_global
                         : evaluation.elements[end.owner].on_side(end.side).in_global;
}

Balance FreeBodies::balance_of(int body, const State& state, const Evaluation& evaluation) const {
  const BodyState& motion = state.bodies[body];
  Balance balance =
      inertia_and_stiffness(model_.bodies[body], points_of(body), model_.gravity, motion, evaluation.bodies[body]);
  for (const End& end : ends_[body]) subtract_wrench(*end.place, motion, wrench_at(end, evaluation), balance);
  return balance;
}

void FreeBodies::forget_round_off_of_forces(int body, const State& state, const Evaluation& evaluation,
                                            Balance& balance) const {
  constexpr double kUnits = 64.0 * std::numeric_limits<double>::epsilon();
  const BodyState& motion = state.bodies[body];
  // By the acceleration that a force alone would give the body, and by its moment about any of the mass points: the
  // torque of a strut on two pins is nothing but the round-off of that.
  VecX by_acceleration = VecX::Zero(motion.a.size());
  double mass = 0.0;
  double extent = 0.0;
  for (const MassPoint& point : points_of(body)) {
    by_acceleration += point.mass * point.Psi_t_L.colwise().norm().transpose();
    mass += point.mass;
    extent = std::max(extent, point.s0_L.norm());
  }
  if (mass > 0.0) by_acceleration /= mass;
  VecX terms = VecX::Zero(motion.a.size());
  for (const End& end : ends_[body]) {
    const Mat3X& Psi_r = end.place->Psi_r_L;
    const Mat3X J_Psi_r = exponential_rate(Psi_r * motion.a) * Psi_r;
    const double reach = place(*end.place, motion).lever.norm() + extent;
    const double force = wrench_at(end, evaluation).force.norm();
    terms += force * (by_acceleration + reach * J_Psi_r.colwise().norm().transpose());
  }
  auto modal = balance.rows.tail(terms.size()).array();
  modal = (modal.abs() <= kUnits * terms.array()).select(0.0, modal).eval();
}

double largest_force_in(const Model& model, const Evaluation& evaluation) {
  const double length = model.length_scale();
  double largest = 0.0;
  for (std::size_t k = 0; k < evaluation.joints.size(); ++k) {
    const JointWrenches& joint = evaluation.joints[k];
    largest = std::max(largest, joint.total_on(Side::child).in_global.force.norm());
    const std::vector<bool> turns = turning_speeds(*model.joints[k].type);
    for (Eigen::Index c = 0; c < joint.tau.size(); ++c) {
      largest = std::max(largest, std::abs(joint.tau(c)) / (turns[static_cast<std::size_t>(c)] ? length : 1.0));
    }
  }
  for (std::size_t c = 0; c < evaluation.couplings.size(); ++c) {
    for (const CouplingTerm& term : model.couplings[c].terms) {
      const joints::JointType& type = *model.joints[term.joint].type;
      const auto speed = static_cast<std::size_t>(first_u(type, term.word) + term.component);
      const double force = std::abs(evaluation.couplings[c] * term.factor);
      largest = std::max(largest, force / (turning_speeds(type)[speed] ? length : 1.0));
    }
  }
  for (const ElementWrenches& element : evaluation.elements) {
    largest = std::max(largest, element.on_side(Side::child).in_global.force.norm());
  }
  return largest;
}

double largest_torque_in(const Model& model, const Evaluation& evaluation) {
  double largest = model.length_scale() * largest_force_in(model, evaluation);
  for (const JointWrenches& joint : evaluation.joints) {
    largest = std::max(largest, joint.total_on(Side::child).in_global.torque.norm());
  }
  for (const ElementWrenches& element : evaluation.elements) {
    largest = std::max(largest, element.on_side(Side::child).in_global.torque.norm());
  }
  return largest;
}

}  // namespace concord::compare
