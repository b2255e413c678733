#include "compare/equilibrium/acceleration_scale.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/decompositions.h"
#include "compare/audit/free_body.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/equilibrium/joint_changes.h"
#include "compare/verdict/spring_terms.h"

namespace concord::compare {

namespace {

/// Sums of forces on each body [N]; a torque counts as its force at the machine's length.
std::vector<double> forces_on_bodies(const Model& model, const Evaluation& evaluation) {
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
/// coordinates at most, one by one [1/(kg m)]: no more than it causes of the body alone.
std::vector<VecX> responses_to_forces(const Model& model, const Chart& chart) {
  const MatX causes = smallest_least_squares(inertia_of(model, chart), chart.basis().transpose());
  std::vector<VecX> responses(model.bodies.size(), VecX::Zero(chart.n()));
  Eigen::Index column = 0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    responses[i] = model.length_scale() * causes.middleCols<6>(column).rowwise().norm();
    const double size = responses[i].norm() * mass_of(model.bodies[i]) * model.length_scale();
    if (size > 1.0) responses[i] /= size;
    column += 6 + chart.origin().bodies[i].a.size();
  }
  return responses;
}

}  // namespace

double reference_acceleration(const Model& model, const Evaluation& evaluation) {
  const std::vector<double> forces = forces_on_bodies(model, evaluation);
  double largest = model.gravity.norm();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const double mass = mass_of(model.bodies[i]);
    if (mass > 0.0) largest = std::max(largest, forces[i] / mass);
  }
  return largest / model.length_scale();
}

AccelerationScale acceleration_scale(const Model& model, const Chart& chart, const State& state,
                                     const Evaluation& evaluation) {
  AccelerationScale scale{model.gravity.norm() / model.length_scale(), 0.0, VecX::Zero(chart.n())};
  const std::vector<double> forces = forces_on_bodies(model, evaluation);
  const std::vector<double> terms = spring_terms_on_bodies(model, state);
  const std::vector<VecX> responses = responses_to_forces(model, chart);
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const double response = responses[i].norm();
    scale.reference = std::max(scale.reference, forces[i] * response);
    scale.terms = std::max(scale.terms, terms[i] * response);
    scale.terms_in_coordinates += terms[i] * responses[i];
  }
  return scale;
}

}  // namespace concord::compare
