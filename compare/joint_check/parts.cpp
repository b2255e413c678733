#include "compare/joint_check/parts.h"

namespace concord::compare::joint_check {

namespace {

Attachment attachment(const Model& model, int body, Numbers& numbers) {
  const int m = model.bodies[body].n_modes();
  Attachment made;
  made.body = body;
  made.point_L = numbers.vector(0.35);
  made.C = numbers.rotation();
  made.Psi_t_L = numbers.columns(m, 0.6);
  made.Psi_r_L = numbers.columns(m, 1.1);
  return made;
}

}  // namespace

Body rigid_body(const std::string& name, Numbers& numbers) {
  Body body;
  body.name = name;
  body.mass = 1.3 + 0.8 * numbers();
  body.center_of_mass_L = numbers.vector(0.2);
  const Mat3 axes = numbers.rotation();
  body.inertia_L = axes * Vec3(0.021, 0.034, 0.047).asDiagonal() * axes.transpose() * (1.5 + 0.5 * numbers());
  return body;
}

Body flexible_body(const std::string& name, int m, Numbers& numbers) {
  Body body;
  body.name = name;
  ModalData modal;
  for (int p = 0; p < 11; ++p) {
    const double mass = 0.2 + 0.1 * numbers();
    const Vec3 place = numbers.vector(0.4);
    modal.mass_points.push_back({mass, place, numbers.columns(m, 0.7)});
  }
  modal.G = mass_integrals(modal.mass_points, m);
  MatX factor(m, m);
  for (Eigen::Index c = 0; c < m; ++c) factor.col(c) = numbers.vector(m, 1.0);
  modal.stiffness = 90.0 * (factor * factor.transpose() + MatX::Identity(m, m));
  modal.damping = 0.004 * modal.stiffness;
  body.modal = modal;
  body.a_start = numbers.vector(m, 0.15);
  body.adot_start = numbers.vector(m, 0.8);
  return body;
}

Joint joint(const Model& model, const std::string& name, const JointType& type, int parent, int child, const VecX& q,
            const VecX& u, StartRole role, Numbers& numbers) {
  Joint made;
  made.name = name;
  made.type = &type;
  const Attachment on_parent = attachment(model, parent, numbers);
  made.sides = {on_parent, attachment(model, child, numbers)};
  for (std::size_t k = 0; k < type.permits.size(); ++k) {
    const int word = static_cast<int>(k);
    const joints::Permit& permit = type.permits[k];
    const StartRole of_word = n_q(permit) > 0 ? role : StartRole::unsaid;
    made.start.push_back(
        {of_word, of_word, q.segment(first_q(type, word), n_q(permit)), u.segment(first_u(type, word), n_u(permit))});
  }
  return made;
}

VecX free_q(Numbers& numbers) {
  VecX q(7);
  q << numbers.vector(3, 0.8), numbers.vector(4, 1.0).normalized();
  return q;
}

}  // namespace concord::compare::joint_check
