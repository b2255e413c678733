#include "cartesian/machine_units.h"

#include <algorithm>
#include <cmath>

#include "cartesian/indices.h"

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
double modal_unit(const Model& model, BodyIndex body, int mode, double length) {
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
  const BodyInertia inertia(pick(model.bodies, body));
  const double shape = std::sqrt(inertia.modal_mass()(mode, mode) / inertia.mass());
  return shape > 0.0 && std::isfinite(shape) ? length / shape : 1.0;
}

}  // namespace

VecX machine_units(const Model& model, const Layout& layout) {
  const double length = model.length_scale();
  VecX units = VecX::Ones(layout.n_Y());
  for (const BodyIndex i : layout.moving_bodies()) {
    layout.v(units, i).setConstant(length);
    for (int mode = 0; mode < layout.n_modes(i); ++mode) {
      layout.adot(units, i)(mode) = modal_unit(model, i, mode, length);
    }
  }
  return units;
}

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

double compliance_of(const BodyInertia& inertia, int mode) {
  constexpr double kLeast = 1e-4;  // far above what counts as dependent where nothing but modes can close a machine
  const double stiffer = stiffening_of(inertia) * inertia.stiffness()(mode, mode) / inertia.modal_mass()(mode, mode);
  return std::max(kLeast, 1.0 / std::sqrt(1.0 + std::max(0.0, stiffer)));
}

}  // namespace concord::cartesian
