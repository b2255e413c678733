#include "cartesian/bodies/machine_scales.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "common/joints/facts.h"

namespace concord::cartesian {

namespace {

/// The largest that a unit of a mode moves any node of its body, turns at `length`.
double largest_at_nodes(const ModalData& modal, int mode, double length) {
  double largest = 0.0;
  for (const ModalNode& node : modal.nodes) {
    largest = std::max({largest, node.Psi_t_L.col(mode).norm(), node.Psi_r_L.col(mode).norm() * length});
  }
  return largest;
}

/// Size of a mode's rate that moves some joint of its body by `length` per second (C44). What a joint at a node of
/// vibration moves by is the round-off of the shape.
double modal_unit(const Model& model, const BodyInertia& inertia, BodyIndex body, int mode, double length) {
  constexpr double kRoundOff = 1e-9;
  double largest = 0.0;
  for (const Joint& joint : model.joints) {
    for (const Attachment& side : joint.sides) {
      if (body_of(side) != body) continue;
      largest = std::max(largest, side.Psi_t_L.col(mode).norm());
      largest = std::max(largest, side.Psi_r_L.col(mode).norm() * length);
    }
  }
  const auto& modal = pick(model.bodies, body).modal;
  if (modal && largest > kRoundOff * largest_at_nodes(*modal, mode, length)) return length / largest;
  // It moves no joint: by its size at a typical mass point.
  const double shape = std::sqrt(inertia.modal_mass()(mode, mode) / inertia.mass());
  return shape > 0.0 && std::isfinite(shape) ? length / shape : 1.0;
}

/// MachineScales::stiffening of a body.
double stiffening_of(const BodyInertia& inertia) {
  constexpr double kHeavier = 1e6;
  constexpr double kStiff = 1e-9;  // of the body's largest frequency squared: below, a mode is free
  const VecX squared = inertia.stiffness().diagonal().cwiseQuotient(inertia.modal_mass().diagonal());
  double slowest = HUGE_VAL;
  for (const double one : squared) {
    if (one > kStiff * squared.maxCoeff()) slowest = std::min(slowest, one);
  }
  return slowest < HUGE_VAL ? kHeavier / slowest : 0.0;
}

/// The steepest mean slope of a law in its coordinate's unit, per `unit` of it [1/s].
struct SlopeOfLaw {
  double unit;

  double operator()(const ConstantSpeed& law) const { return std::abs(law.speed) / unit; }

  double operator()(const Harmonic& law) const { return std::abs(law.amplitude * law.frequency) / unit; }

  double operator()(const SmoothStep& law) const { return std::abs(law.to - law.from) / (law.t1 - law.t0) / unit; }

  /// A power of time has no steepest slope: of c_k t^k the rate at which its k-th derivative alone would take it by the
  /// unit.
  double operator()(const Polynomial& law) const {
    double largest = 0.0;
    double derivative = 1.0;  // k-th of t^k
    for (std::size_t k = 1; k < law.coefficients.size(); ++k) {
      derivative *= static_cast<double>(k);
      const double in_units = derivative * std::abs(law.coefficients[k]) / unit;
      largest = std::max(largest, std::pow(in_units, 1.0 / static_cast<double>(k)));
    }
    return largest;
  }

  double operator()(const SplineTable& law) const {
    double steepest = 0.0;
    for (std::size_t k = 0; k + 1 < law.times().size(); ++k) {
      const double chord = (law.values()[k + 1] - law.values()[k]) / (law.times()[k + 1] - law.times()[k]);
      steepest = std::max(steepest, std::abs(chord));
    }
    return steepest / unit;
  }
};

}  // namespace

MachineScales::MachineScales(const Model& model, const Layout& layout, const ByBody<BodyInertia>& inertias)
    : length(model.length_scale()),
      mass(0.0),
      driven_rate(rate_of_drivers(model)),
      units(VecX::Ones(layout.n_Y())),
      displacements(units),
      stiffening(model.bodies.size()) {
  constexpr double kLeast = 1e-4;  // far above what counts as dependent where nothing but modes can close a machine
  for (const BodyIndex i : layout.moving_bodies()) {
    const BodyInertia& inertia = inertias[i];
    mass += inertia.mass();
    stiffening[i] = stiffening_of(inertia);
    layout.v(units, i).setConstant(length);
    layout.v(displacements, i).setConstant(length);
    for (int mode = 0; mode < layout.n_modes(i); ++mode) {
      const double unit = modal_unit(model, inertia, i, mode, length);
      const double stiffer = stiffening[i] * inertia.stiffness()(mode, mode) / inertia.modal_mass()(mode, mode);
      const double compliance = std::max(kLeast, 1.0 / std::sqrt(1.0 + std::max(0.0, stiffer)));
      layout.adot(units, i)(mode) = unit;
      layout.adot(displacements, i)(mode) = compliance * unit;
    }
  }
}

double rate_of_drivers(const Model& model) {
  const double length = model.length_scale();
  double largest = 0.0;
  for (const Joint& joint : model.joints) {
    for (const Driver& driver : joint.drivers) {
      const bool slides = joints::is_length(joint.type->permits[driver.word], driver.component);
      largest = std::max(largest, std::visit(SlopeOfLaw{slides ? length : 1.0}, driver.law));
    }
  }
  return largest;
}

}  // namespace concord::cartesian
