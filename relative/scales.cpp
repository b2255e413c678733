#include "relative/scales.h"

#include <algorithm>

namespace concord::relative {

namespace {

/// Largest displacement of mode k at the body's nodes and mass points, per unit of its modal coordinate.
double largest_displacement(const ModalData& modal, Eigen::Index k) {
  double largest = 0.0;
  for (const ModalNode& node : modal.nodes) largest = std::max(largest, node.Psi_t_L.col(k).norm());
  for (const MassPoint& point : modal.mass_points) largest = std::max(largest, point.Psi_t_L.col(k).norm());
  return largest;
}

}  // namespace

Scales::Scales(const Model& model, const Topology& topology)
    : length_(model.length_scale()), speeds_(VecX::Ones(topology.n_u)) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Motion motion(*model.joints[k].type);
    for (int c = 0; c < motion.n_u(); ++c) {
      if (motion.kind(c).is_length) speeds_(topology.joints[k].first_u + c) = length_;
    }
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    for (int k = 0; k < model.bodies[i].n_modes(); ++k) {
      const double displacement = largest_displacement(*model.bodies[i].modal, k);
      if (displacement > 0.0) speeds_(topology.modes[i].first_u + k) = length_ / displacement;
    }
  }
}

VecX Scales::rows(const Closure& closure) const {
  VecX rows = VecX::Ones(closure.n_rows());
  for (const Closure::Cut& cut : closure.cuts()) {
    rows.segment(cut.first_row, cut.measure.n_linear_rows()).setConstant(length_);
  }
  return rows;
}

MatX Scales::scaled(const MatX& Phi_u, const Closure& closure) const {
  return rows(closure).cwiseInverse().asDiagonal() * Phi_u * speeds_.head(Phi_u.cols()).asDiagonal();
}

}  // namespace concord::relative
