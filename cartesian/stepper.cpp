#include "cartesian/stepper.h"

#include <algorithm>
#include <cmath>

namespace concord::cartesian {

namespace {

struct Mode {
  double mass;       // kg, of a mode whose shape has no unit
  double frequency;  // rad/s, of the mode alone
};

Mode mode_of(const ModalData& modal, int k) {
  double mass = 0.0;
  for (int c = 0; c < 3; ++c) mass += modal.G(4 + 3 * k + c, 4 + 3 * k + c);
  return {mass, std::sqrt(std::abs(modal.stiffness(k, k)) / mass)};
}

}  // namespace

VecX absolute_tolerances(const Equations& equations, const Motion& start, double rtol) {
  const Model& model = equations.model();
  const Layout& layout = equations.layout();
  const double length = model.length_scale();
  double speed = std::sqrt(model.gravity.norm() * length);
  for (int i = 1; i < layout.n_bodies(); ++i) {
    speed = std::max({speed, layout.v(start.Y, i).norm(), layout.omega(start.Y, i).norm() * length});
    for (int k = 0; k < layout.n_modes(i); ++k) {
      const Mode mode = mode_of(*model.bodies[i].modal, k);
      const double rate =
          std::max(std::abs(layout.adot(start.Y, i)(k)), mode.frequency * std::abs(layout.a(start.q, i)(k)));
      speed = std::max(speed, rate * std::sqrt(mode.mass / equations.inertia(i).mass()));
    }
  }
  constexpr double kRoundOff = 1e-12;  // of a length per second: what closing leaves of the speed of a machine at rest
  if (!(speed > kRoundOff * length)) speed = length;
  double energy = 0.0;
  VecX scales(layout.n_q() + layout.n_Y() + 1);
  auto q = scales.head(layout.n_q());
  auto Y = scales.segment(layout.n_q(), layout.n_Y());
  for (int i = 1; i < layout.n_bodies(); ++i) {
    layout.r(q, i).setConstant(length);
    layout.p(q, i).setConstant(1.0);
    layout.v(Y, i).setConstant(speed);
    layout.omega(Y, i).setConstant(speed / length);
    energy += equations.inertia(i).mass() * speed * speed;
    for (int k = 0; k < layout.n_modes(i); ++k) {
      const Mode mode = mode_of(*model.bodies[i].modal, k);
      const double modal_speed = speed * std::sqrt(equations.inertia(i).mass() / mode.mass);
      layout.adot(Y, i)(k) = modal_speed;
      layout.a(q, i)(k) = modal_speed / std::max(mode.frequency, speed / length);
    }
  }
  scales(scales.size() - 1) = energy;
  return rtol * scales;
}

}  // namespace concord::cartesian
