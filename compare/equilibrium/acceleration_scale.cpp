#include "compare/equilibrium/acceleration_scale.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/decompositions.h"
#include "compare/audit/free_body.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/equilibrium/joint_changes.h"
#include "compare/resolution/spring_terms.h"

namespace concord::compare {

namespace {

/// What springs, actuators and couplings exert on the speeds of joint k, as forces [N]: the sum of their sizes, though
/// they may cancel.
double force_of_laws(const Model& model, std::size_t k, const State& state, const Evaluation& evaluation) {
  const Joint& joint = model.joints[k];
  VecX sizes = coupled_tau(model, static_cast<int>(k), evaluation.couplings).cwiseAbs();
  if (!joint.springs.empty()) {
    const std::vector<LawOfForce> laws = laws_of_springs(joint);
    const VecX tau = tau_by_laws(joint, laws, motion_of(model, k, state), state.t);
    sizes += tau.array().isNaN().select(VecX::Zero(tau.size()), tau.cwiseAbs());
  }
  const std::vector<bool> turns = turning_speeds(*joint.type);
  double sum = 0.0;
  for (Eigen::Index c = 0; c < sizes.size(); ++c) {
    sum += sizes(c) / (turns[static_cast<std::size_t>(c)] ? model.length_scale() : 1.0);
  }
  return sum;
}

/// What strain exerts on a body's mass, as a force that would move it as much as the modes [N].
double force_of_strain(const Body& body, const BodyState& state) {
  if (!body.modal) return 0.0;
  const VecX modal = (body.modal->stiffness * state.a).cwiseAbs();
  const VecX masses = modal_masses(*body.modal);
  double sum = 0.0;
  for (Eigen::Index m = 0; m < modal.size(); ++m) {
    if (masses(m) > 0.0) sum += modal(m) * std::sqrt(mass_of(body) / masses(m));
  }
  return sum;
}

/// Sums of forces on each body [N]; a torque counts as its force at the machine's length.
std::vector<double> forces_on_bodies(const Model& model, const State& state, const Evaluation& evaluation) {
  std::vector<double> forces(model.bodies.size(), 0.0);
  const auto add = [&](int body, const Wrench& wrench) {
    forces[body] += std::max(wrench.force.norm(), wrench.torque.norm() / model.length_scale());
  };
  for (const Side side : {Side::parent, Side::child}) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      add(model.joints[k].on(side).body, evaluation.joints[k].total_on(side).in_C);
    }
    for (std::size_t k = 0; k < model.elements.size(); ++k) {
      const Attachment* end = end_of(model.elements[k], side);
      if (end != nullptr) add(end->body, evaluation.elements[k].on_side(side).in_C);
    }
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const double of_laws = force_of_laws(model, k, state, evaluation);
    for (const Side side : {Side::parent, Side::child}) forces[model.joints[k].on(side).body] += of_laws;
  }
  for (std::size_t i = 1; i < forces.size(); ++i) forces[i] += force_of_strain(model.bodies[i], state.bodies[i]);
  return forces;
}

/// Sums over each body of what its springs add up on the way to their forces [N]; torques as in forces_on_bodies().
std::vector<double> spring_terms_on_bodies(const Model& model, const State& state) {
  std::vector<double> sums(model.bodies.size(), 0.0);
  const auto add = [&](int body, const SpringTerms& terms) {
    sums[body] += std::max(terms.force, terms.torque / model.length_scale());
  };
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const SpringTerms terms = spring_terms(model.joints[k], state.q[k], state.u[k], state.t);
    for (const Attachment& side : model.joints[k].sides) add(side.body, terms);
  }
  for (std::size_t e = 0; e < model.elements.size(); ++e) {
    const ForceElement& element = model.elements[e];
    const SpringTerms terms = spring_terms(element, state, state.known_angle(e));
    for (const Side side : kSides) {
      if (const Attachment* end = end_of(element, side)) add(end->body, terms);
    }
  }
  return sums;
}

/// Twice the kinetic energy of the chart's origin as a quadratic form of the rates of its coordinates [kg m2].
MatX inertia_of(const Model& model, const Chart& chart) {
  MatX velocities(chart.basis().rows(), chart.n());
  for (int k = 0; k < chart.n(); ++k) velocities.col(k) = chart.velocities(VecX::Unit(chart.n(), k));
  MatX inertia = MatX::Zero(chart.n(), chart.n());
  std::vector<MassPoint> of_rigid;
  Eigen::Index row = 0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const BodyState& body = chart.origin().bodies[i];
    const Mat3 A = rotation_of(body.p);
    const MatX of_body = velocities.middleRows(row, 6 + body.a.size());
    for (const MassPoint& point : mass_points_of(model.bodies[i], of_rigid)) {
      MatX moved = of_body.topRows<3>();
      const Vec3 s = A * (point.s0_L + point.Psi_t_L * body.a);
      for (int k = 0; k < chart.n(); ++k) moved.col(k) += Vec3(of_body.col(k).segment<3>(3)).cross(s);
      if (body.a.size() > 0) moved += A * point.Psi_t_L * of_body.bottomRows(body.a.size());
      inertia += point.mass * moved.transpose() * moved;
    }
    row += of_body.rows();
  }
  return inertia;
}

/// What a unit of force on each body, at its origin or as a torque at the machine's length, causes in the chart's
/// coordinates at most, one by one [1/(kg m)].
std::vector<VecX> responses_to_forces(const Model& model, const Chart& chart) {
  const MatX causes = smallest_least_squares(inertia_of(model, chart), chart.basis().transpose());
  std::vector<VecX> responses(model.bodies.size(), VecX::Zero(chart.n()));
  Eigen::Index column = 0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    responses[i] = model.length_scale() * causes.middleCols(column, 6).rowwise().norm();
    column += 6 + chart.origin().bodies[i].a.size();
  }
  return responses;
}

}  // namespace

double reference_acceleration(const Model& model, const State& state, const Evaluation& evaluation) {
  const std::vector<double> forces = forces_on_bodies(model, state, evaluation);
  double largest = model.gravity.norm();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const double mass = mass_of(model.bodies[i]);
    if (mass > 0.0) largest = std::max(largest, forces[i] / mass);
  }
  return largest / model.length_scale();
}

AccelerationScale acceleration_scale(const Model& model, const Chart& chart, const State& state,
                                     const Evaluation& evaluation) {
  AccelerationScale scale{reference_acceleration(model, state, evaluation), 0.0};
  const double of_gravity = model.gravity.norm() / model.length_scale();
  const std::vector<double> terms = spring_terms_on_bodies(model, state);
  const bool has_terms = std::any_of(terms.begin(), terms.end(), [](double size) { return size > 0.0; });
  if (chart.n() == 0 || (scale.reference <= of_gravity && !has_terms)) return scale;
  std::vector<VecX> responses = responses_to_forces(model, chart);
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const double alone = 1.0 / (mass_of(model.bodies[i]) * model.length_scale());
    const double size = responses[i].norm();
    if (size > alone) responses[i] *= alone / size;
  }
  const auto caused = [&](const std::vector<double>& forces) {
    double largest = 0.0;
    for (std::size_t i = 1; i < model.bodies.size(); ++i) {
      if (mass_of(model.bodies[i]) > 0.0) largest = std::max(largest, forces[i] * responses[i].norm());
    }
    return largest;
  };
  scale.reference = std::max(of_gravity, caused(forces_on_bodies(model, state, evaluation)));
  scale.terms = caused(terms);
  scale.terms_in_coordinates = VecX::Zero(chart.n());
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    if (mass_of(model.bodies[i]) > 0.0) scale.terms_in_coordinates += terms[i] * responses[i];
  }
  return scale;
}

}  // namespace concord::compare
