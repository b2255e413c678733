#include "compare/audit/energy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "compare/audit/free_body.h"
#include "compare/audit/places.h"

namespace concord::compare {

namespace {

constexpr double kEnergyRoundOff = 1e-15;  // of the terms of an energy
constexpr double kHalfAUnit = 1.2e-16;     // of a number: what a step may lose of it
/// Of what the largest force would do along the length, or the largest torque over a turn of one: the part of it that a
/// place off by its tolerance does, where a thousand times the tolerance of energy is allowed, is no error.
constexpr double kSmallestScale = 1e-3;

struct Energies {
  double kinetic = 0.0;
  double potential = 0.0;
  double terms = 0.0;  // the sizes of all that is added up
  double still = 0.0;  // of these, the weights of bodies that hardly move in a step
};

/// Whether a step leaves most of a place as it was, to its last digits: what rounds it then goes one way.
bool hardly_moves(const BodyState& body, double step) {
  constexpr double kFewUnits = 1e-14;
  return body.v.norm() * step <= kFewUnits * body.r.norm();
}

Energies energies_of(const Model& model, const State& state, double step = 0.0) {
  Energies energies;
  std::vector<MassPoint> of_rigid;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const BodyState& body = state.bodies[i];
    const Mat3 A = rotation_of(body.p);
    for (const MassPoint& point : mass_points_of(model.bodies[i], of_rigid)) {
      const Vec3 s = A * (point.s0_L + point.Psi_t_L * body.a);
      const Vec3 velocity = body.v + body.omega.cross(s) + A * (point.Psi_t_L * body.adot);
      energies.kinetic += 0.5 * point.mass * velocity.squaredNorm();
      const double weight = point.mass * model.gravity.dot(body.r + s);
      energies.potential -= weight;
      energies.terms += std::abs(weight);
      if (hardly_moves(body, step)) energies.still += std::abs(weight);
    }
    if (!model.bodies[i].modal) continue;
    const double bending = 0.5 * body.a.dot(model.bodies[i].modal->stiffness * body.a);
    energies.potential += bending;
    energies.terms += std::abs(bending);
  }
  energies.terms += energies.kinetic;
  return energies;
}

}  // namespace

double mechanical_energy(const Model& model, const State& state) {
  const Energies energies = energies_of(model, state);
  return energies.kinetic + energies.potential;
}

EnergyReport audit_energy(const Model& model, const Trajectory& trajectory) {
  EnergyReport report;
  if (trajectory.samples.empty()) return report;
  const Energies start = energies_of(model, trajectory.samples.front().state);
  const double steps = std::max(1.0, static_cast<double>(trajectory.statistics.steps));
  const double until = trajectory.samples.back().state.t - trajectory.samples.front().state.t;
  // What comes and goes between two samples leaves its errors behind, too.
  report.scale = trajectory.statistics.largest_work;
  double lowest = start.potential;
  double highest = start.potential;
  for (const Sample& sample : trajectory.samples) {
    const Energies now = energies_of(model, sample.state, until / steps);
    lowest = std::min(lowest, now.potential);
    highest = std::max(highest, now.potential);
    report.scale = std::max({report.scale, now.kinetic, std::abs(sample.work), highest - lowest,
                             kSmallestScale * largest_torque_in(model, sample.evaluation)});
    const double gained = now.kinetic + now.potential - start.kinetic - start.potential;
    // High above the ground, or at rest, the sums lose more digits than the energy that moves has. Each step rounds the
    // state once more: a body that hardly moves may stay where it is while its forces work, time and again.
    const double steps_so_far =
        until > 0.0 ? steps * (sample.state.t - trajectory.samples.front().state.t) / until : 0.0;
    const double round_off = kEnergyRoundOff * (now.terms + start.terms) +
                             kHalfAUnit * (std::sqrt(steps_so_far) * now.terms + steps_so_far * now.still);
    const double drift = std::abs(gained - sample.work);
    if (!std::isnan(report.drift) && !(drift <= report.drift)) {
      report.drift = drift;
      report.t_drift = sample.state.t;
      report.round_off = round_off;
    }
    double error = drift - round_off;
    if (error < 0.0) error = 0.0;
    if (!std::isnan(report.error) && !(error <= report.error)) {
      report.error = error;
      report.t = sample.state.t;
    }
  }
  return report;
}

std::string drift_text(const EnergyReport& report, double allowed) {
  return fmt::format("{:.1e} J at t = {:.4g} s, allowed {:.1e} J", report.drift, report.t_drift,
                     allowed * report.scale + report.round_off);
}

}  // namespace concord::compare
