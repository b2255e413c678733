#include "relative/run/integrated_variables.h"

#include <algorithm>
#include <cmath>

#include "relative/bodies/turns.h"

namespace concord::relative {

namespace {

/// Deformations are small parts of the length.
constexpr double kSmallDeformation = 1e-3;
/// What drivers and forces do to a machine that turns at its rate is a small part of its energy.
constexpr double kSmallWork = 1e-2;

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
  const auto place_of = [](const std::vector<int>& all, int one) {
    return static_cast<int>(std::lower_bound(all.begin(), all.end(), one) - all.begin());
  };
  for (const Span& modes : topology.modes) {
    for (int k = 0; k < modes.n_q; ++k) {
      modal_coordinates_.push_back(place_of(q_, modes.first_q + k));
      modal_rates_.push_back(static_cast<int>(n_q()) + place_of(u_, modes.first_u + k));
    }
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

VecX sizes_of(const IntegratedVariables& variables, const Equations& equations, const Coordinates& start) {
  const MachineSize& size = equations.size();
  const double rate = size.rate_at(start.u);
  VecX q = size.coordinates();
  VecX u = rate * size.speeds();
  for (const Span& modes : equations.topology().modes) {
    q.segment(modes.first_q, modes.n_q) *= kSmallDeformation;
    u.segment(modes.first_u, modes.n_u) *= kSmallDeformation;
  }
  VecX sizes = VecX::Ones(variables.size());
  variables.pack(q, u, sizes);
  // Work is compared with the kinetic energy that the machine's own rate stands for.
  if (size.mass() > 0.0) sizes(variables.work()) = kSmallWork * size.mass() * std::pow(rate * size.length(), 2);
  return sizes;
}

}  // namespace concord::relative
