#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "compare/audit/energy.h"

/// Every integrator of both solvers on a damped flexible pendulum: energy, and errors that fall with the tolerance.
namespace concord::verification {
namespace {

/// A soft blade on a tilted hinge, held by a stiff arm off its axis, let go bent and moving.
const std::string kBlade = R"(format = 1
gravity = [1.0, -9.5, 2.0]
[[body]]
name = "blade"
start.a = [0.004, -0.001, 0.003, 0.001]
start.adot = [0.05, 0.1, -0.02, 0.06]
[body.beam]
first_end = [0.05, 0.02, -0.03]
x = [6, 2, -3]
z = [2, 3, 6]
length = 0.8
elements = 16
section = { width_y = 0.02, width_z = 0.012 }
youngs_modulus = 4.0e8
poissons_ratio = 0.33
density = 1400
support = "cantilever"
modes = { bending_xy = [1, 2], bending_xz = [1], torsion = [1] }
damping_ratio = 0.03
[[joint]]
name = "root"
type = "revolute"
parent = { body = "ground", point = [0.1, 0.2, -0.1], x = [1, 0, 0], z = [0, -1, 2] }
child = { body = "blade", node = "first", offset = [-0.05, 0.03, 0.02], axis = [1, -2, 1], angle = "50 deg" }
start.turn_z = { keep = "-40 deg", keep_speed = 4 }
)";

constexpr double kUntil = 0.4;
constexpr int kSamples = 20;

/// Hinge angle and modal coordinates of a run, each on its own largest value.
MatX path(const Trajectory& trajectory) {
  const auto& samples = trajectory.samples;
  const Eigen::Index n = samples.front().state.bodies[1].a.size();
  MatX rows(n + 1, static_cast<Eigen::Index>(samples.size()));
  for (std::size_t k = 0; k < samples.size(); ++k) {
    rows.col(static_cast<Eigen::Index>(k)) << samples[k].state.q[0](0), samples[k].state.bodies[1].a;
  }
  return rows;
}

double distance(const MatX& found, const MatX& exact) {
  const VecX sizes = exact.rowwise().lpNorm<Eigen::Infinity>();
  return (sizes.cwiseInverse().asDiagonal() * (found - exact)).lpNorm<Eigen::Infinity>();
}

/// A run far more exact than those that are measured against it, by the other solver.
MatX reference(const Model& model, const Solver& measured) {
  const auto other = measured.name() == "cartesian" ? relative::make_solver(model) : cartesian::make_solver(model);
  return path(run(*other, kUntil, 1e-12, kSamples));
}

}  // namespace

TEST_CASE("Each integrator balances the energy of a damped flexible pendulum, and its error falls with the tolerance",
          "[quick]") {
  const Model model = parse(kBlade);
  fmt::print("| solver    | integrator | rtol  | steps | error of the path | error of energy |\n");
  for (const auto& solver : both_solvers(model)) {
    const MatX exact = reference(model, *solver);
    for (const std::string& integrator : solver->integrators()) {
      std::vector<double> errors;
      for (const double rtol : {1e-6, 1e-8, 1e-10}) {
        INFO(solver->name() << ", " << integrator << ", rtol " << rtol);
        const Trajectory trajectory = run(*solver, kUntil, rtol, kSamples, integrator);
        const double energy = compare::audit_energy(model, trajectory).relative();
        errors.push_back(distance(path(trajectory), exact));
        fmt::print("| {:<9} | {:<10} | {:.0e} | {:>5} | {:>17.1e} | {:>15.1e} |\n", solver->name(), integrator, rtol,
                   trajectory.statistics.steps, errors.back(), energy);
        // Damping takes its part: the balance is no balance of zeros.
        CHECK(trajectory.samples.back().work < -0.01);
        CHECK(energy < 100.0 * rtol);
        CHECK(errors.back() < 100.0 * rtol);
      }
      INFO(solver->name() << ", " << integrator);
      CHECK(errors[1] < 0.1 * errors[0]);
      CHECK(errors[2] < 0.1 * errors[1]);
    }
  }
}

}  // namespace concord::verification
