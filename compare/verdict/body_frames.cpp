#include "compare/verdict/body_frames.h"

#include <Eigen/Geometry>

#include "common/overloaded.h"
#include "compare/audit/places.h"

namespace concord::compare {

Body with_frame(Body body, const Pose& frame) {
  const Mat3 to_new = frame.A.transpose();
  if (body.pose_guess)
    body.pose_guess = Pose{body.pose_guess->r + body.pose_guess->A * frame.r, body.pose_guess->A * frame.A};
  if (!body.modal) {
    body.center_of_mass_L = to_new * (body.center_of_mass_L - frame.r);
    body.inertia_L = to_new * body.inertia_L * frame.A;
    return body;
  }
  ModalData& modal = *body.modal;
  modal.beam.reset();
  // w = [1; s_0; psi_1; ...] becomes X w.
  MatX X = MatX::Identity(modal.G.rows(), modal.G.cols());
  for (Eigen::Index block = 1; block < X.rows(); block += 3) X.block<3, 3>(block, block) = to_new;
  X.block<3, 1>(1, 0) = -to_new * frame.r;
  modal.G = X * modal.G * X.transpose();
  for (ModalNode& node : modal.nodes) {
    node.s0_L = to_new * (node.s0_L - frame.r);
    node.Psi_t_L = to_new * node.Psi_t_L;
    node.Psi_r_L = to_new * node.Psi_r_L;
  }
  for (MassPoint& point : modal.mass_points) {
    point.s0_L = to_new * (point.s0_L - frame.r);
    point.Psi_t_L = to_new * point.Psi_t_L;
  }
  return body;
}

Attachment with_frame(Attachment side, const Pose& frame) {
  const Mat3 to_new = frame.A.transpose();
  side.point_L = to_new * (side.point_L - frame.r);
  side.C = to_new * side.C;
  side.Psi_t_L = to_new * side.Psi_t_L;
  side.Psi_r_L = to_new * side.Psi_r_L;
  return side;
}

BodyState moved_motion(BodyState body, const Pose& frame) {
  const Mat3 A = rotation_of(body.p);
  const Vec3 arm = A * frame.r;
  body.r += arm;
  body.v += body.omega.cross(arm);
  body.p = euler_parameters_of(A * frame.A);
  return body;
}

void for_each_attachment(Model& model, const std::function<void(Attachment&)>& edit) {
  for (Joint& joint : model.joints) {
    for (Attachment& side : joint.sides) edit(side);
  }
  const auto both = [&](auto& element) {
    for (Attachment& end : element.ends) edit(end);
  };
  for (ForceElement& element : model.elements) {
    std::visit(Overloaded{[&](Load& load) { edit(load.at); }, [&](LineSpring& spring) { both(spring); },
                          [&](TurnSpring& spring) { both(spring); }, [&](Bushing& bushing) { both(bushing); },
                          [&](Tire& tire) { edit(tire.wheel); }},
               element.what);
  }
}

Vec4 euler_parameters_of(const Mat3& A) {
  const Eigen::Quaterniond p(A);
  return {p.w(), p.x(), p.y(), p.z()};
}

}  // namespace concord::compare
