#include <catch2/catch.hpp>
#include <cmath>

#include "tests/verification/closed_forms.h"
#include "tests/verification/judged_machines.h"

namespace concord::verification {
namespace {

/// The coupler of the driven slider-crank, `factor` times as stiff, with 5 % modal damping.
Model with_stiff_coupler(double factor) {
  Model model = read("slider_crank_flexible");
  ModalData& modal = *model.bodies[2].modal;
  modal.beam.reset();  // it is stiffer than the file says
  modal.stiffness *= factor;
  modal.damping.setZero(modal.n_modes(), modal.n_modes());
  for (int k = 0; k < modal.n_modes(); ++k) {
    modal.damping(k, k) = 2.0 * 0.05 * std::sqrt(modal.stiffness(k, k));  // unit modal mass
  }
  return model;
}

/// The same machine, its coupler undeformed for ever: mass, centre and inertia from the rigid part of the integrals.
Model with_rigid_coupler() {
  Model model = read("slider_crank_flexible");
  Body& coupler = model.bodies[2];
  const MatX G = coupler.modal->G;
  const Mat3 P = G.block<3, 3>(1, 1);
  coupler.mass = G(0, 0);
  coupler.center_of_mass_L = G.block<3, 1>(1, 0) / coupler.mass;
  const Mat3 about_center = P - coupler.mass * coupler.center_of_mass_L * coupler.center_of_mass_L.transpose();
  coupler.inertia_L = about_center.trace() * Mat3::Identity() - about_center;
  coupler.modal.reset();
  coupler.a_start.resize(0);
  coupler.adot_start.resize(0);
  for (Joint& joint : model.joints) {
    for (Attachment& side : joint.sides) {
      side.Psi_t_L.resize(3, 0);
      side.Psi_r_L.resize(3, 0);
    }
  }
  return model;
}

/// Largest difference of any joint's reaction, forces and torques per length, between two runs, after the start has
/// died away.
double largest_difference(const Trajectory& one, const Trajectory& other, double length) {
  constexpr double kDiedAway = 0.05;  // s
  double largest = 0.0;
  for (std::size_t k = 0; k < one.samples.size(); ++k) {
    if (one.samples[k].state.t < kDiedAway) continue;
    for (std::size_t joint = 0; joint < one.samples[k].evaluation.joints.size(); ++joint) {
      for (const Side side : {Side::parent, Side::child}) {
        const Wrench& bent = one.samples[k].evaluation.joints[joint].reaction_on(side).in_C;
        const Wrench& rigid = other.samples[k].evaluation.joints[joint].reaction_on(side).in_C;
        const double torque = (bent.torque - rigid.torque).norm();
        largest = std::max({largest, (bent.force - rigid.force).norm(), torque / length});
      }
    }
  }
  return largest;
}

TEST_CASE("As the coupler gets stiffer, damped flexible reactions tend to the rigid ones, by each stiff integrator",
          "[stiff]") {
  constexpr double kUntil = 0.08;
  constexpr int kSamples = 160;
  const Model rigid = with_rigid_coupler();
  const std::vector<Model> stiff{with_stiff_coupler(1e2), with_stiff_coupler(1e4)};
  const char* integrators[] = {"ida", "dirk"};
  for (std::size_t who = 0; who < 2; ++who) {
    const Trajectory reference = run(*both_solvers(rigid)[who], kUntil, 1e-9, kSamples);
    std::vector<double> differences;
    for (const Model& model : stiff) {
      const Trajectory bent = run(*both_solvers(model)[who], kUntil, 1e-10, kSamples, integrators[who]);
      differences.push_back(largest_difference(bent, reference, rigid.length_scale()));
    }
    INFO(integrators[who] << ": " << differences[0] << " N, then " << differences[1] << " N");
    if (std::getenv("CONCORD_PRINT_DIGITS") != nullptr) {
      fmt::print("stiff limit, {}: {:.3g} N, then {:.3g} N: {:.1f} times closer\n", integrators[who], differences[0],
                 differences[1], differences[0] / differences[1]);
    }
    CHECK(differences[0] > 0.01);
    CHECK(differences[0] / differences[1] >= 50.0);
  }
}

TEST_CASE("A stiff beam that hardly vibrates in a machine of large motions is judged with default tolerances",
          "[stiff][quick]") {
  expect_to_agree(machine_of("modes", "micro_four_bar"), {});
}

}  // namespace
}  // namespace concord::verification
