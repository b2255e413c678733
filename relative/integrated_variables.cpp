#include "relative/integrated_variables.h"

#include <algorithm>
#include <cmath>

#include "relative/turns.h"

namespace concord::relative {

namespace {

/// Deformations are small parts of the length.
constexpr double kSmallDeformation = 1e-3;

/// The machine's rate in a run [1/s].
double rate_of_run(const Model& model, const Scales& scales, const Coordinates& start, double until) {
  const VecX& speed_units = scales.speeds();
  double rate = std::sqrt(model.gravity.norm() / scales.length());
  for (Eigen::Index c = 0; c < speed_units.size(); ++c) rate = std::max(rate, std::abs(start.u(c)) / speed_units(c));
  return rate == 0.0 ? 1.0 / until : rate;
}

double mass_of(const Model& model) {
  double mass = 0.0;
  for (const Body& body : model.bodies) mass += body.modal ? body.modal->G(0, 0) : body.mass;
  return mass;
}

}  // namespace

IntegratedVariables::IntegratedVariables(const Equations& equations) {
  const Model& model = equations.model();
  const Topology& topology = equations.topology();
  std::vector<char> q_is_driven(topology.n_q, 0);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Driver& driver : model.joints[k].drivers) {
      q_is_driven[topology.joints[k].first_q + first_q(*model.joints[k].type, driver.word) + driver.component] = 1;
    }
  }
  for (int c = 0; c < topology.n_q; ++c) {
    if (q_is_driven[c] == 0) q_.push_back(c);
  }
  for (int c = 0; c < topology.n_tree_u; ++c) {
    if (equations.driven()[c] == 0) u_.push_back(c);
  }
}

void IntegratedVariables::unpack(const Eigen::Ref<const VecX>& y, Coordinates& coordinates) const {
  for (std::size_t c = 0; c < q_.size(); ++c) coordinates.q(q_[c]) = y(c);
  for (std::size_t c = 0; c < u_.size(); ++c) coordinates.u(u_[c]) = y(q_.size() + c);
}

void IntegratedVariables::pack(const VecX& q, const VecX& u, Eigen::Ref<VecX> y) const {
  for (std::size_t c = 0; c < q_.size(); ++c) y(c) = q(q_[c]);
  for (std::size_t c = 0; c < u_.size(); ++c) y(q_.size() + c) = u(u_[c]);
}

void IntegratedVariables::take_off(const VecX& turns, Eigen::Ref<VecX> y) const {
  for (std::size_t c = 0; c < q_.size(); ++c) y(c) = add_turns(y(c), -turns(q_[c]));
}

VecX sizes_of(const IntegratedVariables& variables, const Equations& equations, const Scales& scales,
              const Coordinates& start, double until) {
  const Model& model = equations.model();
  const Topology& topology = equations.topology();
  const VecX& speed_units = scales.speeds();
  const double rate = rate_of_run(model, scales, start, until);
  VecX q = VecX::Ones(topology.n_q);
  VecX u = rate * speed_units;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Mobilizer& mobilizer = equations.kinematics().mobilizer(JointIndex(k));
    for (int c = 0; c < mobilizer.n_u(); ++c) {
      if (mobilizer.kind(c).is_length) q(topology.joints[k].first_q + c) = scales.length();
    }
  }
  for (const Span& modes : topology.modes) {
    q.segment(modes.first_q, modes.n_q) = kSmallDeformation * speed_units.segment(modes.first_u, modes.n_u);
    u.segment(modes.first_u, modes.n_u) *= kSmallDeformation;
  }
  // Work is compared with the kinetic energy that the machine's own rate stands for.
  const double work = mass_of(model) * rate * rate * scales.length() * scales.length();
  VecX sizes = VecX::Ones(variables.size());
  variables.pack(q, u, sizes);
  sizes(variables.work()) = work > 0.0 ? work : 1.0;
  return sizes;
}

}  // namespace concord::relative
