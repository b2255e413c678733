#include "relative/scales.h"

#include <algorithm>
#include <cmath>

#include "common/overloaded.h"

namespace concord::relative {

namespace {

/// Largest displacement of mode k at the body's nodes and mass points, per unit of its modal coordinate.
double largest_displacement(const ModalData& modal, Eigen::Index k) {
  double largest = 0.0;
  for (const ModalNode& node : modal.nodes) largest = std::max(largest, node.Psi_t_L.col(k).norm());
  for (const MassPoint& point : modal.mass_points) largest = std::max(largest, point.Psi_t_L.col(k).norm());
  return largest;
}

double total_mass(const Model& model) {
  double mass = 0.0;
  for (const Body& body : model.bodies) mass += body.modal ? body.modal->G(0, 0) : body.mass;
  return mass;
}

/// The largest that a law exerts where it is stretched by so much, or that its actuator does at 17 times of the run.
double largest_of(const ForceLaw& law, double stretch, double until) {
  constexpr int kLooks = 16;
  double largest = std::max(std::abs(law.stiffness) * stretch, std::abs(law.preload));
  for (int k = 0; law.actuator && k <= kLooks; ++k) {
    largest = std::max(largest, std::abs(evaluate_actuator(law, until * k / kLooks)));
  }
  return largest;
}

/// The same of what an element makes of a motion by the length, and by a radian: forces, and torques over the length.
double largest_of_wrenches(const ForceElement& element, double length) {
  double largest = 0.0;
  each_quantity(
      element,
      Overloaded{elements::IgnoreQuantity{},
                 [&](const elements::WrenchMatrix<const Mat6>& matrix) {
                   if (matrix.per_rate) return;
                   largest = std::max({largest, matrix.value.topLeftCorner<3, 3>().diagonal().maxCoeff() * length,
                                       matrix.value.bottomRightCorner<3, 3>().diagonal().maxCoeff() / length});
                 },
                 [&](const elements::Wrench6<const Vec6>& wrench) {
                   largest = std::max({largest, wrench.value.head<3>().norm(), wrench.value.tail<3>().norm() / length});
                 }});
  return largest;
}

/// Largest force of a load, of an actuator, or of a spring that is stretched by the length or a radian [N]; torques
/// over the length.
double largest_force(const Model& model, double length) {
  const double until = model.run.until;
  double largest = 0.0;
  for (const Joint& joint : model.joints) {
    const Mobilizer mobilizer(*joint.type);
    for (const JointSpring& spring : joint.springs) {
      const bool slides = mobilizer.kind(first_u(*joint.type, spring.word) + spring.component).is_length;
      const double exerted =
          slides ? largest_of(spring.law, length, until) : largest_of(spring.law, 1.0, until) / length;
      largest = std::max(largest, exerted);
    }
  }
  for (const ForceElement& element : model.elements) {
    const double exerted = std::visit(
        Overloaded{[&](const Load& load) { return std::max(load.force.norm(), load.torque.norm() / length); },
                   [&](const LineSpring& spring) { return largest_of(spring.law, length, until); },
                   [&](const TurnSpring& spring) { return largest_of(spring.law, 1.0, until) / length; },
                   [&](const auto&) { return largest_of_wrenches(element, length); }},
        element.what);
    largest = std::max(largest, exerted);
  }
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

double machine_rate(const Model& model) {
  const double length = machine_length(model);
  double rate = std::sqrt(model.gravity.norm() / length);
  for (const Joint& joint : model.joints) {
    const Mobilizer mobilizer(*joint.type);
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const WordStart& start = joint.start[word];
      if (start.role_u == StartRole::unsaid) continue;
      for (int c = 0; c < static_cast<int>(start.u.size()); ++c) {
        const bool slides = mobilizer.kind(first_u(*joint.type, static_cast<int>(word)) + c).is_length;
        rate = std::max(rate, std::abs(start.u(c)) / (slides ? length : 1.0));
      }
    }
    for (const Driver& driver : joint.drivers) {
      const bool slides = mobilizer.kind(first_u(*joint.type, driver.word) + driver.component).is_length;
      rate = std::max(rate, units_per_second(driver.law, slides ? length : 1.0));
    }
  }
  const double mass = total_mass(model);
  if (rate == 0.0 && mass > 0.0) rate = std::max(rate, std::sqrt(largest_force(model, length) / (mass * length)));
  return rate;
}

Scales::Scales(const Model& model, const Topology& topology)
    : length_(machine_length(model)), speeds_(VecX::Ones(topology.n_u)) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Mobilizer mobilizer(*model.joints[k].type);
    for (int c = 0; c < mobilizer.n_u(); ++c) {
      if (mobilizer.kind(c).is_length) speeds_(topology.joints[k].first_u + c) = length_;
    }
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    for (int k = 0; k < model.bodies[i].n_modes(); ++k) {
      const double displacement = largest_displacement(*model.bodies[i].modal, k);
      if (displacement > 0.0) speeds_(topology.modes[i].first_u + k) = length_ / displacement;
    }
  }
}

VecX Scales::coordinates(const Model& model, const Topology& topology) const {
  VecX units = VecX::Ones(topology.n_q);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Mobilizer mobilizer(*model.joints[k].type);
    // Slides and motions by functions have as many coordinates as speeds and stand before a ball.
    for (int c = 0; c < mobilizer.n_u(); ++c) {
      if (mobilizer.kind(c).is_length) units(topology.joints[k].first_q + c) = length_;
    }
  }
  for (const Span& modes : topology.modes) {
    units.segment(modes.first_q, modes.n_q) = speeds_.segment(modes.first_u, modes.n_u);
  }
  return units;
}

MatX Scales::scaled(const MatX& Phi_u, const Closure& closure) const {
  return closure.row_units().cwiseInverse().asDiagonal() * Phi_u * speeds_.head(Phi_u.cols()).asDiagonal();
}

}  // namespace concord::relative
