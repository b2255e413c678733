#include "cartesian/bodies/body_inertia.h"

namespace concord::cartesian {

BodyInertia::BodyInertia(const Body& body) : n_modes_(body.n_modes()) {
  if (!body.modal) {
    mass_ = body.mass;
    sum_s0_ = body.mass * body.center_of_mass_L;
    // I = tr(P) 1 - P for the second moments P about the centre of mass, so P = tr(I)/2 1 - I.
    sum_s0_s0_ = 0.5 * body.inertia_L.trace() * Mat3::Identity() - body.inertia_L +
                 body.mass * body.center_of_mass_L * body.center_of_mass_L.transpose();
    return;
  }
  const MatX& G = body.modal->G;
  const int m = n_modes_;
  mass_ = G(0, 0);
  sum_s0_ = G.block<3, 1>(1, 0);
  sum_s0_s0_ = G.block<3, 3>(1, 1);
  sum_psi_.resize(3, m);
  sum_s0_psi_.resize(3, 3 * m);
  sum_psi_psi_.resize(3, 3 * m * m);
  modal_mass_.resize(m, m);
  for (int k = 0; k < m; ++k) {
    sum_psi_.col(k) = G.block<3, 1>(4 + 3 * k, 0);
    sum_s0_psi_.middleCols<3>(3 * k) = G.block<3, 3>(1, 4 + 3 * k);
    for (int l = 0; l < m; ++l) {
      sum_psi_psi_.middleCols<3>(3 * (k * m + l)) = G.block<3, 3>(4 + 3 * k, 4 + 3 * l);
      modal_mass_(k, l) = G.block<3, 3>(4 + 3 * k, 4 + 3 * l).trace();
    }
  }
  stiffness_ = body.modal->stiffness;
  damping_ = body.modal->damping;
}

DeformedInertia::DeformedInertia(const BodyInertia& body)
    : body_(body),
      sum_s_(body.sum_s0_),
      sum_s_s_(body.sum_s0_s0_),
      sum_s_psi_(body.sum_s0_psi_),
      sum_sdot_psi_(Mat3X::Zero(3, 3 * body.n_modes())) {}

}  // namespace concord::cartesian
