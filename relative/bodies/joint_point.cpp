#include "relative/bodies/joint_point.h"

#include <fmt/format.h>

#include <numbers>

#include "relative/bodies/exponential_map.h"

namespace concord::relative {

JointPoint::JointPoint(std::string owner, const Attachment& attachment)
    : attachment_(attachment),
      owner_(std::move(owner)),
      is_reference_point_(attachment.Psi_t_L.cols() == 0 && attachment.point_L == Vec3::Zero()),
      s_L_(attachment.point_L),
      C_(attachment.C),
      J_Psi_r_L_(Mat3X::Zero(3, attachment.Psi_r_L.cols())),
      Ga_(Mat6X::Zero(6, attachment.Psi_t_L.cols())) {}

void JointPoint::deform_flexible(const double* a, const double* adot) {
  const Eigen::Map<const VecX> modal(a, n_modes());
  const Eigen::Map<const VecX> modal_rate(adot, n_modes());
  const Vec3 theta = attachment_.Psi_r_L.lazyProduct(modal);
  const Vec3 thetadot = attachment_.Psi_r_L.lazyProduct(modal_rate);
  if (!(theta.norm() < std::numbers::pi)) {
    throw SolverError(fmt::format(
        "relative: {}: deformation has turned its frame by {:.3g} rad against the body; less than pi is allowed",
        owner_, theta.norm()));
  }
  const ExponentialMap map = exponential_map(theta);
  s_L_ = attachment_.point_L;
  s_L_.noalias() += attachment_.Psi_t_L.lazyProduct(modal);
  C_ = map.R * attachment_.C;
  J_Psi_r_L_.noalias() = map.J.lazyProduct(attachment_.Psi_r_L);
  sdot_L_ = attachment_.Psi_t_L.lazyProduct(modal_rate);
  turning_L_ = map.J * thetadot;
  Jdot_rate_L_ = tangent_rate(theta, thetadot) * thetadot;
}

void JointPoint::rotate_modes(const Mat3& body_A) {
  Ga_.topRows<3>().noalias() = body_A.lazyProduct(attachment_.Psi_t_L);
  Ga_.bottomRows<3>().noalias() = body_A.lazyProduct(J_Psi_r_L_);
  sdot_ = body_A * sdot_L_;
  turning_ = body_A * turning_L_;
  Jdot_rate_ = body_A * Jdot_rate_L_;
}

void JointPoint::add_deformation(const BodyMotion& body) {
  rotate_modes(body.A);
  v += sdot_;
  omega += turning_;
  add_deformation_bias(body.omega);
}

void JointPoint::remove_deformation(BodyMotion& body) {
  rotate_modes(body.A);
  body.v -= sdot_;
  body.omega -= turning_;
}

void JointPoint::add_deformation_bias(const Vec3& body_omega) {
  bias.head<3>() += 2.0 * body_omega.cross(sdot_);
  bias.tail<3>() = body_omega.cross(turning_) + Jdot_rate_;
}

}  // namespace concord::relative
