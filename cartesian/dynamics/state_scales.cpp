#include "cartesian/dynamics/state_scales.h"

#include <algorithm>
#include <cmath>

namespace concord::cartesian {

namespace {

/// What a row's residual is divided by: its size, or 1 of a row that vanishes.
double divisor(const VecX& row_sizes, RowIndex row) { return row_sizes(row.value) > 0.0 ? row_sizes(row.value) : 1.0; }

struct Mode {
  double mass;       // kg, of a mode whose shape has no unit
  double frequency;  // rad/s, of the mode alone
};

Mode mode_of(const BodyInertia& inertia, int k) {
  const double mass = inertia.modal_mass()(k, k);
  return {mass, std::sqrt(std::abs(inertia.stiffness()(k, k)) / mass)};
}

/// The largest speed of a start [m/s], modal ones as that of their body with the same energy; at least that of falling
/// by the machine's length.
double speed_of_start(const Equations& equations, const VecX& q, const VecX& Y) {
  const Layout& layout = equations.layout();
  const double length = equations.length();
  double speed = std::sqrt(equations.model().gravity.norm() * length);
  for (const BodyIndex i : layout.moving_bodies()) {
    speed = std::max({speed, layout.v(Y, i).norm(), layout.omega(Y, i).norm() * length});
    for (int k = 0; k < layout.n_modes(i); ++k) {
      const Mode mode = mode_of(equations.inertia(i), k);
      const double rate = std::max(std::abs(layout.adot(Y, i)(k)), mode.frequency * std::abs(layout.a(q, i)(k)));
      speed = std::max(speed, rate * std::sqrt(mode.mass / equations.inertia(i).mass()));
    }
  }
  return speed;
}

}  // namespace

double reach_of(const Equations& equations, const Eigen::Ref<const VecX>& q) {
  const Layout& layout = equations.layout();
  const MovingConstraints& constraints = equations.moving_constraints();
  double reach = 1.0;
  for (const BodyIndex i : layout.moving_bodies()) {
    reach = std::max(reach, layout.r(q, i).lpNorm<Eigen::Infinity>() / equations.length());
  }
  for (const JointIndex k : constraints.joints()) {
    for (const Marker& marker : constraints.joint(k).markers) {
      const double far = std::max(marker.lever.lpNorm<Eigen::Infinity>(), marker.point.lpNorm<Eigen::Infinity>());
      reach = std::max(reach, far / equations.length());
    }
  }
  return reach;
}

void measure_round_off(const Equations& equations, double t, const Eigen::Ref<const VecX>& q, RoundOffShares& shares) {
  const MovingConstraints& constraints = equations.moving_constraints();
  const VecX& sizes = equations.row_sizes();
  shares.reach = reach_of(equations, q);
  constraints.write_own_terms(t, shares.terms);
  constraints.write_reaches(shares.reach, shares.reaches);
  for (const RowIndex row : constraints.rows()) {
    const double size = sizes(row.value);
    const double own = size > 0.0 ? shares.terms(row.value) / size : 0.0;
    shares.terms(row.value) = std::max(shares.reaches(row.value), own);
  }
}

double largest_residual(const Equations& equations, const VecX& residual, const VecX* shares) {
  const VecX& sizes = equations.row_sizes();
  double largest = 0.0;
  for (const RowIndex row : equations.constraints().rows()) {
    const double share = shares != nullptr ? (*shares)(row.value) : 1.0;
    const double own = std::abs(residual(row.value)) / (divisor(sizes, row) * share);
    if (std::isnan(own)) return own;
    largest = std::max(largest, own);
  }
  return largest;
}

std::string name_of_largest(const Equations& equations, const VecX& residual) {
  const VecX& sizes = equations.row_sizes();
  RowIndex largest;
  double size = -1.0;
  for (const RowIndex row : equations.constraints().rows()) {
    const double own = std::abs(residual(row.value)) / divisor(sizes, row);
    if (own <= size) continue;
    size = own;
    largest = row;
  }
  return equations.constraints().name_of(largest);
}

double natural_rate(const Equations& equations) {
  const Layout& layout = equations.layout();
  double acceleration = 0.0;
  for (const BodyIndex i : layout.moving_bodies()) {
    const double mass = equations.inertia(i).mass();
    if (!(mass > 0.0)) continue;
    const double force = layout.v(equations.forces(), i).lpNorm<Eigen::Infinity>();
    const double torque = layout.omega(equations.forces(), i).lpNorm<Eigen::Infinity>();
    acceleration = std::max(acceleration, std::max(force, torque / equations.length()) / mass);
  }
  return std::sqrt(acceleration / equations.length());
}

double largest_rate(const Equations& equations, double t, const Eigen::Ref<const VecX>& Y) {
  constexpr double kAtRest = 1e-6;
  const Constraints& constraints = equations.constraints();
  double largest = kAtRest * std::max(natural_rate(equations), equations.scales().driven_rate);
  for (Eigen::Index c = 0; c < Y.size(); ++c) largest = std::max(largest, std::abs(Y(c)) / equations.units()(c));
  for (const JointIndex k : constraints.joints()) {
    const JointLayout& joint = constraints.joint(k);
    for (int own = joint.first_driver; own < joint.n_rows; ++own) {
      const double size = equations.row_sizes()(joint.row(own).value);
      const Driver& driver = pick(equations.model().joints, k).drivers[own - joint.first_driver];
      if (size > 0.0) largest = std::max(largest, std::abs(evaluate(driver.law, t).fdot) / size);
    }
  }
  return largest;
}

double largest_acceleration(const Equations& equations, const Eigen::Ref<const VecX>& Ydot) {
  constexpr double kBroughtToRest = 1e-3;  // of what drivers do at any time
  const double rate = std::max(natural_rate(equations), kBroughtToRest * equations.scales().driven_rate);
  const VecX& units = equations.units();
  return std::max({rate * rate, equations.Y().cwiseQuotient(units).cwiseAbs2().maxCoeff(),
                   Ydot.cwiseQuotient(units).cwiseAbs().maxCoeff()});
}

VecX motion_sizes(const Equations& equations, const VecX& q, const VecX& Y, double until) {
  const Layout& layout = equations.layout();
  const double length = equations.length();
  double speed = speed_of_start(equations, q, Y);
  constexpr double kStandstill = 1e-9;  // of the length in the time of the run: what closing leaves, and no motion
  const double least = length / until;
  if (!(speed > kStandstill * least)) speed = std::max(natural_rate(equations) * length, least);
  double energy = 0.0;
  VecX sizes(layout.n_q() + layout.n_Y() + 1);
  auto of_q = sizes.head(layout.n_q());
  auto of_Y = sizes.segment(layout.n_q(), layout.n_Y());
  for (const BodyIndex i : layout.moving_bodies()) {
    layout.r(of_q, i).setConstant(length);
    layout.p(of_q, i).setConstant(1.0);
    layout.v(of_Y, i).setConstant(speed);
    layout.omega(of_Y, i).setConstant(speed / length);
    energy += equations.inertia(i).mass() * speed * speed;
    for (int k = 0; k < layout.n_modes(i); ++k) {
      const Mode mode = mode_of(equations.inertia(i), k);
      const double modal_speed = speed * std::sqrt(equations.inertia(i).mass() / mode.mass);
      layout.adot(of_Y, i)(k) = modal_speed;
      layout.a(of_q, i)(k) = modal_speed / std::max(mode.frequency, speed / length);
    }
  }
  sizes(sizes.size() - 1) = energy;
  return sizes;
}

}  // namespace concord::cartesian
