#include "compare/audit/machine_size.h"

#include <algorithm>
#include <cmath>

#include "compare/audit/free_body.h"

namespace concord::compare {

double size_of_places(const State& state, double length) {
  for (const BodyState& body : state.bodies) length = std::max(length, body.r.cwiseAbs().maxCoeff());
  return length;
}

double size_of_speeds(const State& state, double length) {
  double size = 0.0;
  for (const BodyState& body : state.bodies) size = std::max({size, body.v.norm(), body.omega.norm() * length});
  return size;
}

MachineSize::MachineSize(const Model& model)
    : length(model.length_scale()), falling(std::sqrt(model.gravity.norm() * length)), place(length) {
  natural = model.run.until > 0.0 ? std::max(falling, length / model.run.until) : falling;
  for (const Body& body : model.bodies) {
    mass += mass_of(body);
    modal.emplace_back(VecX::Zero(body.n_modes()));
    modal_rate.emplace_back(VecX::Zero(body.n_modes()));
    shapes.push_back(largest_displacements(body));
  }
}

MachineSize::MachineSize(const Model& model, const Trajectory& run) : MachineSize(model) {
  const double until = run.samples.empty() ? 0.0 : run.samples.back().state.t;
  natural = until > 0.0 ? std::max(falling, length / until) : falling;
  for (const Sample& sample : run.samples) take(sample.state);
}

void MachineSize::take(const State& state) {
  place = std::max(place, size_of_places(state, length));
  speed = std::max(speed, size_of_speeds(state, length));
  turning = speed / length;
  for (std::size_t i = 1; i < state.bodies.size(); ++i) {
    modal[i] = modal[i].cwiseMax(state.bodies[i].a.cwiseAbs());
    modal_rate[i] = modal_rate[i].cwiseMax(state.bodies[i].adot.cwiseAbs());
  }
}

double MachineSize::speed_or(double part_of_natural) const { return std::max(speed, part_of_natural * natural); }

}  // namespace concord::compare
