#include "compare/invariance/modes.h"

#include "common/decompositions.h"
#include "common/products.h"

namespace concord::compare::invariance {

namespace {

void change_modes(Body& body, const MatX& T) {
  ModalData& modal = *body.modal;
  modal.beam.reset();
  modal.stiffness = congruence(T, modal.stiffness);
  modal.damping = congruence(T, modal.damping);
  modal.frequencies.resize(0);
  MatX X = MatX::Identity(modal.G.rows(), modal.G.cols());
  for (Eigen::Index row = 0; row < T.rows(); ++row) {
    for (Eigen::Index column = 0; column < T.cols(); ++column) {
      X.block<3, 3>(4 + 3 * row, 4 + 3 * column) = T(column, row) * Mat3::Identity();
    }
  }
  modal.G = congruence(X.transpose(), modal.G);
  for (ModalNode& node : modal.nodes) {
    node.Psi_t_L = node.Psi_t_L * T;
    node.Psi_r_L = node.Psi_r_L * T;
  }
  for (MassPoint& point : modal.mass_points) point.Psi_t_L = point.Psi_t_L * T;
  body.a_start = solve_square(T, body.a_start);
  body.adot_start = solve_square(T, body.adot_start);
}

}  // namespace

Change with_modes(const std::vector<MatX>& T) {
  Change change;
  change.model = [T](Model model) {
    for (std::size_t i = 1; i < T.size(); ++i) {
      if (T[i].size() > 0) change_modes(model.bodies[i], T[i]);
    }
    for_each_attachment(model, [&](Attachment& side) {
      const MatX& of_body = T[static_cast<std::size_t>(side.body)];
      if (of_body.size() == 0) return;
      side.Psi_t_L = side.Psi_t_L * of_body;
      side.Psi_r_L = side.Psi_r_L * of_body;
    });
    return model;
  };
  change.state = [T](State state) {
    for (std::size_t i = 1; i < T.size(); ++i) {
      if (T[i].size() == 0) continue;
      state.bodies[i].a = solve_square(T[i], state.bodies[i].a);
      state.bodies[i].adot = solve_square(T[i], state.bodies[i].adot);
    }
    return state;
  };
  change.back = [T](State state) {
    for (std::size_t i = 1; i < T.size(); ++i) {
      if (T[i].size() == 0) continue;
      state.bodies[i].a = T[i] * state.bodies[i].a;
      state.bodies[i].adot = T[i] * state.bodies[i].adot;
    }
    return state;
  };
  change.evaluation = [T](const State&, Evaluation evaluation) {
    for (std::size_t i = 1; i < T.size(); ++i) {
      if (T[i].size() > 0) evaluation.bodies[i].addot = T[i] * evaluation.bodies[i].addot;
    }
    return evaluation;
  };
  return change;
}

}  // namespace concord::compare::invariance
