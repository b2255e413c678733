#include "cartesian/residual_measures.h"

#include <algorithm>
#include <cmath>

namespace concord::cartesian {

namespace {

/// What a row's residual is divided by: its size, or 1 of a row that vanishes.
double divisor(const VecX& row_sizes, RowIndex row) { return row_sizes(row.value) > 0.0 ? row_sizes(row.value) : 1.0; }

double farthest(const Equations& equations, const Eigen::Ref<const VecX>& q) {
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

}  // namespace

void measure_round_off(const Equations& equations, double t, const Eigen::Ref<const VecX>& q, RoundOffShares& shares) {
  const MovingConstraints& constraints = equations.moving_constraints();
  const VecX& sizes = equations.row_sizes();
  shares.reach = farthest(equations, q);
  constraints.write_own_terms(t, shares.terms);
  constraints.write_reaches(shares.reach, shares.reaches);
  for (const RowIndex row : constraints.rows()) {
    const double size = sizes(row.value);
    const double own = size > 0.0 ? shares.terms(row.value) / size : 0.0;
    shares.terms(row.value) = std::max(shares.reaches(row.value), own);
  }
}

double largest_residual(const Equations& equations, const VecX& residual, const RoundOffShares& shares) {
  const VecX& sizes = equations.row_sizes();
  double largest = 0.0;
  for (const RowIndex row : equations.constraints().rows()) {
    const double own = std::abs(residual(row.value)) / (divisor(sizes, row) * shares.terms(row.value));
    if (std::isnan(own)) return own;
    largest = std::max(largest, own);
  }
  return largest;
}

double largest_velocity_residual(const Equations& equations, const VecX& velocity_residual) {
  const VecX& sizes = equations.row_sizes();
  double largest = 0.0;
  for (const RowIndex row : equations.constraints().rows()) {
    const double own = std::abs(velocity_residual(row.value)) / divisor(sizes, row);
    if (std::isnan(own)) return own;
    largest = std::max(largest, own);
  }
  return largest;
}

double largest_velocity_residual_by_reach(const Equations& equations, const VecX& velocity_residual,
                                          const RoundOffShares& shares) {
  return largest_velocity_residual(equations, velocity_residual.cwiseQuotient(shares.reaches));
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
  double largest = kAtRest * std::max(natural_rate(equations), equations.driven_rate());
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

}  // namespace concord::cartesian
