#include "relative/bodies/machine_size.h"

#include <algorithm>
#include <cmath>

#include "common/overloaded.h"
#include "relative/bodies/motion_structure.h"

namespace concord::relative {

namespace {

/// Whether one body holds two points of joints or force elements at different places.
bool has_distances(const Model& model) {
  std::vector<std::pair<int, Vec3>> places;
  const auto differs = [&](const Attachment& one) {
    for (const auto& [body, point] : places) {
      if (body == one.body && point != one.point_L) return true;
    }
    places.emplace_back(one.body, one.point_L);
    return false;
  };
  for (const Joint& joint : model.joints) {
    if (differs(joint.sides[0]) || differs(joint.sides[1])) return true;
  }
  for (const ForceElement& element : model.elements) {
    for (const Side side : {Side::parent, Side::child}) {
      const Attachment* end = end_of(element, side);
      if (end != nullptr && differs(*end)) return true;
    }
  }
  return false;
}

Vec3 center_of_mass(const Body& body) {
  if (!body.modal) return body.center_of_mass_L;
  return body.modal->G.block<3, 1>(1, 0) / body.modal->G(0, 0);
}

double radius_of_gyration(const Body& body) {
  if (!body.modal) return body.mass > 0.0 ? std::sqrt(0.5 * body.inertia_L.trace() / body.mass) : 0.0;
  return std::sqrt(body.modal->G.block<3, 3>(1, 1).trace() / body.modal->G(0, 0));
}

/// Largest displacement of mode k at the body's nodes and mass points, per unit of its modal coordinate.
double largest_displacement(const ModalData& modal, Eigen::Index k) {
  double largest = 0.0;
  for (const ModalNode& node : modal.nodes) largest = std::max(largest, node.Psi_t_L.col(k).norm());
  for (const MassPoint& point : modal.mass_points) largest = std::max(largest, point.Psi_t_L.col(k).norm());
  return largest;
}

/// How many of its units a law passes in a second, where it is fastest: straight pieces by their slope, a term c t^k of
/// a polynomial by the time 1 / rate in which it would pass one if it were (rate t)^k / k! (R64).
double units_per_second(const TimeFunction& law, double unit) {
  return std::visit(
      Overloaded{[unit](const ConstantSpeed& of) { return std::abs(of.speed) / unit; },
                 [unit](const Harmonic& of) { return std::abs(of.amplitude * of.frequency) / unit; },
                 [unit](const SmoothStep& of) { return std::abs(of.to - of.from) / (of.t1 - of.t0) / unit; },
                 [unit](const Polynomial& of) {
                   double rate = 0.0;
                   double factorial = 1.0;
                   for (int k = 1; k < static_cast<int>(of.coefficients.size()); ++k) {
                     factorial *= k;
                     rate = std::max(rate, std::pow(factorial * std::abs(of.coefficients[k]) / unit, 1.0 / k));
                   }
                   return rate;
                 },
                 [unit](const SplineTable& of) {
                   double steepest = 0.0;
                   for (std::size_t k = 1; k < of.times().size(); ++k) {
                     const double passed = std::abs(of.values()[k] - of.values()[k - 1]);
                     steepest = std::max(steepest, passed / (of.times()[k] - of.times()[k - 1]));
                   }
                   return steepest / unit;
                 }},
      law);
}

}  // namespace

double largest_entry(const VecX& values) { return values.size() == 0 ? 0.0 : values.cwiseAbs().maxCoeff(); }

double machine_length(const Model& model) {
  if (has_distances(model)) return model.length_scale();
  double length = 0.0;
  for (const Joint& joint : model.joints) {
    for (const Attachment& side : joint.sides) {
      if (side.body == kGround) continue;
      length = std::max(length, (center_of_mass(model.bodies[side.body]) - side.point_L).norm());
    }
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) length = std::max(length, radius_of_gyration(model.bodies[i]));
  return length > 0.0 ? length : model.length_scale();
}

MachineSize::MachineSize(const Model& model, const Topology& topology)
    : length_(machine_length(model)), speeds_(VecX::Ones(topology.n_u)), coordinates_(VecX::Ones(topology.n_q)) {
  for (const Body& body : model.bodies) mass_ += body.modal ? body.modal->G(0, 0) : body.mass;
  set_units(model, topology);
  set_rate(model, topology);
}

void MachineSize::set_units(const Model& model, const Topology& topology) {  // (R63)
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const MotionStructure structure = structure_of(*model.joints[k].type);
    for (int c = 0; c < structure.n_u; ++c) {
      if (!structure.kinds[c].is_length) continue;
      speeds_(topology.joints[k].first_u + c) = length_;
      coordinates_(topology.joints[k].first_q + c) = length_;  // lengths stand before a ball
    }
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Span& modes = topology.modes[i];
    for (int k = 0; k < modes.n_u; ++k) {
      const double displacement = largest_displacement(*model.bodies[i].modal, k);
      if (displacement > 0.0) speeds_(modes.first_u + k) = length_ / displacement;
    }
    coordinates_.segment(modes.first_q, modes.n_q) = speeds_.segment(modes.first_u, modes.n_u);
  }
}

void MachineSize::set_rate(const Model& model, const Topology& topology) {  // (R64)
  rate_ = std::sqrt(model.gravity.norm() / length_);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const auto unit = [&](int word, int c) {
      return speeds_(topology.joints[k].first_u + first_u(*joint.type, word) + c);
    };
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const WordStart& start = joint.start[word];
      if (start.role_u == StartRole::unsaid) continue;
      for (int c = 0; c < static_cast<int>(start.u.size()); ++c) {
        rate_ = std::max(rate_, std::abs(start.u(c)) / unit(static_cast<int>(word), c));
      }
    }
    for (const Driver& driver : joint.drivers) {
      rate_ = std::max(rate_, units_per_second(driver.law, unit(driver.word, driver.component)));
    }
  }
  if (rate_ == 0.0) rate_ = 1.0 / model.run.until;
}

double MachineSize::largest_coordinate(const VecX& q) const { return largest_entry(q.cwiseQuotient(coordinates_)); }
double MachineSize::largest_speed(const VecX& u) const { return largest_entry(u.cwiseQuotient(speeds_)); }
double MachineSize::rate_at(const VecX& u) const { return std::max(rate_, largest_speed(u)); }

}  // namespace concord::relative
