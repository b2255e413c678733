#include "compare/states/body_frames.h"

#include <Eigen/Geometry>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/flexible/beam.h"
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
  if (modal.beam) {
    BeamSpecification beam = *modal.beam;
    beam.first_end_L = to_new * (beam.first_end_L - frame.r);
    beam.axes = to_new * beam.axes;
    modal.beam = std::make_shared<const BeamSpecification>(std::move(beam));
  }
  for (ModalNode& node : modal.nodes) {
    node.s0_L = to_new * (node.s0_L - frame.r);
    node.Psi_t_L = to_new * node.Psi_t_L;
    node.Psi_r_L = to_new * node.Psi_r_L;
  }
  for (MassPoint& point : modal.mass_points) {
    point.s0_L = to_new * (point.s0_L - frame.r);
    point.Psi_t_L = to_new * point.Psi_t_L;
  }
  // Summed up anew: about a frame that lies far away the integrals hold the body's own only as small differences.
  modal.G = mass_integrals(modal.mass_points, modal.n_modes());
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

void take_arm_off(const Vec3& arm, const Vec3& omega, BodyAcceleration& body) {
  body.vdot -= body.omegadot.cross(arm) + omega.cross(omega.cross(arm));
}

namespace {

/// The same for those that are looked at and those that are changed.
template <class AnyModel, class Visit>
void visit_attachments(AnyModel& model, const Visit& visit) {
  for (auto& joint : model.joints) {
    for (auto& side : joint.sides) visit(side);
  }
  for (auto& element : model.elements) {
    for (auto& end : ends_of(element)) visit(end);
  }
}

}  // namespace

void for_each_attachment(Model& model, const std::function<void(Attachment&)>& edit) { visit_attachments(model, edit); }

void for_each_attachment(const Model& model, const std::function<void(const Attachment&)>& look) {
  visit_attachments(model, look);
}

Vec4 euler_parameters_of(const Mat3& A) {
  const Eigen::Quaterniond p(A);
  return {p.w(), p.x(), p.y(), p.z()};
}

}  // namespace concord::compare
