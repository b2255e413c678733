#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "compare/invariance/change.h"
#include "compare/states/branch.h"
#include "relative/solver.h"

/// Shipped machines, and their numbers as lists that can be compared.
namespace concord::compare::invariance {

inline Model shipped(const std::string& name) {
  return read_model(std::string(CONCORD_DATA) + "/models/" + name + ".toml");
}

inline SolverMakers both_solvers() { return {cartesian::make_solver, relative::make_solver}; }

inline State start_of(const Model& model) { return relative::make_solver(model)->assemble(); }

/// Machines that have between them every joint type with a rule of its own, every force element, couplings, drivers,
/// loops and modes.
inline const std::vector<std::string>& all_kinds() {
  static const std::vector<std::string> names{"slider_crank_spatial_flexible",
                                              "planetary_differential",
                                              "driven_linkage",
                                              "suspension_two_rods",
                                              "tire_test_rig",
                                              "chaplygin_sleigh",
                                              "ball_on_turntable",
                                              "springs_in_a_loop",
                                              "body_on_bushings",
                                              "torsion_pendulum",
                                              "motor_and_crossed_link",
                                              "loads_on_rigid_bodies",
                                              "hinged_link_and_piston",
                                              "joint_springs_tree",
                                              "turn_spring_between_yokes"};
  return names;
}

inline void append(std::vector<double>& numbers, const Eigen::Ref<const MatX>& values) {
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    for (Eigen::Index r = 0; r < values.rows(); ++r) numbers.push_back(values(r, c));
  }
}

/// The numbers of a description: bodies, joints with starts, couplings, places and loads of force elements.
inline std::vector<double> numbers_of(Model model) {
  std::vector<double> numbers;
  append(numbers, model.gravity);
  for (const Body& body : model.bodies) {
    numbers.push_back(body.mass);
    append(numbers, body.center_of_mass_L);
    append(numbers, body.inertia_L);
    append(numbers, body.a_start);
    append(numbers, body.adot_start);
    if (!body.modal) continue;
    append(numbers, body.modal->G);
    append(numbers, body.modal->stiffness);
  }
  for (const Joint& joint : model.joints) {
    numbers.push_back(joint.named_as_cut ? 1.0 : 0.0);
    for (const WordStart& start : joint.start) {
      append(numbers, start.q);
      append(numbers, start.u);
    }
    for (const JointSpring& spring : joint.springs)
      numbers.insert(numbers.end(), {spring.law.free, spring.law.stiffness});
    for (const Driver& driver : joint.drivers) numbers.push_back(evaluate(driver.law, 0.1).f);
  }
  for (const Coupling& coupling : model.couplings) {
    numbers.push_back(coupling.offset);
    for (const CouplingTerm& term : coupling.terms) numbers.insert(numbers.end(), {double(term.joint), term.factor});
  }
  for_each_attachment(model, [&](Attachment& side) {
    numbers.push_back(side.body);
    append(numbers, side.point_L);
    append(numbers, side.C);
    append(numbers, side.Psi_t_L);
    append(numbers, side.Psi_r_L);
  });
  for (const ForceElement& element : model.elements) {
    if (const auto* load = std::get_if<Load>(&element.what)) append(numbers, load->force);
    if (const auto* bushing = std::get_if<Bushing>(&element.what)) append(numbers, bushing->stiffness);
  }
  return numbers;
}

inline std::vector<double> numbers_of(const State& state) {
  std::vector<double> numbers;
  for (const BodyState& body : state.bodies) {
    append(numbers, body.r);
    append(numbers, body.p * std::copysign(1.0, body.p(0)));
    append(numbers, body.v);
    append(numbers, body.omega);
    append(numbers, body.a);
    append(numbers, body.adot);
  }
  for (VecX q : state.q) {
    const bool has_ball = q.size() >= 4;  // the last four numbers: Euler parameters of either sign
    if (has_ball) q.tail<4>() *= std::copysign(1.0, q(q.size() - 4));
    append(numbers, q);
  }
  for (const VecX& u : state.u) append(numbers, u);
  return numbers;
}

/// The largest difference of two lists, relative to the largest number or not; infinite if they differ in length.
inline double difference(const std::vector<double>& one, const std::vector<double>& other, bool relative = true) {
  if (one.size() != other.size()) return std::numeric_limits<double>::infinity();
  double size = 1.0;
  double most = 0.0;
  for (std::size_t k = 0; k < one.size(); ++k) {
    size = std::max(size, std::abs(one[k]));
    most = std::max(most, std::abs(one[k] - other[k]));
  }
  return relative ? most / size : most;
}

}  // namespace concord::compare::invariance
