#include "cartesian/dynamics/reactions.h"

#include "cartesian/bodies/small_products.h"
#include "cartesian/forces/joint_springs.h"

namespace concord::cartesian {

namespace {

/// The same wrench in the joint frame and in global axes (C41), paper (29).
SideWrench seen_from(const Mat3& A_joint, const Wrench& in_global) {
  return {{transpose_times(A_joint, in_global.force), transpose_times(A_joint, in_global.torque)}, in_global};
}

/// Generalized force columns of the body, weighted with -lambda, as a wrench at the marker (C41).
Wrench from_columns(const Marker& marker, const Eigen::Ref<const MatX>& Phi_Y_transposed,
                    const Eigen::Ref<const VecX>& lambda) {
  Vec6 generalized = Vec6::Zero();
  for (Eigen::Index row = 0; row < lambda.size(); ++row) {
    generalized -= lambda(row) * Phi_Y_transposed.col(row).head<6>();
  }
  const Vec3 force = generalized.head<3>();
  return {force, generalized.tail<3>() - cross(marker.lever, force)};
}

/// A joint with ground has no columns on that side: the wrench on ground follows from the rows themselves.
Wrench on_ground(const JointEquations& joint, Side side, const Eigen::Ref<const VecX>& lambda) {
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();
  for (Eigen::Index row = 0; row < lambda.size(); ++row) {
    force -= lambda(row) * joint.rows[row].over_d;
    torque -= lambda(row) * joint.rows[row].over_rho;
  }
  const Mat3& A_joint = joint.marker(Side::parent).A_joint;
  force = A_joint * force;
  torque = A_joint * torque;
  if (side == Side::child) return {force, torque};
  return {-force, -(torque + joint.gap.cross(force))};
}

/// The coordinate wrench of tau on both sides, parent first, global axes.
std::array<Wrench, 2> coordinate_wrenches(const Joint& stated, const JointEquations& joint,
                                          const Eigen::Ref<const VecX>& tau) {
  const Vec6 in_C = coordinate_wrench(*stated.type, joint.motion, tau);
  const Mat3& A_joint = joint.marker(Side::parent).A_joint;
  const Vec3 force = A_joint * in_C.head<3>();
  const Vec3 torque = A_joint * in_C.tail<3>();
  return {Wrench{-force, -(torque + joint.gap.cross(force))}, Wrench{force, torque}};
}

Wrench difference(const Wrench& total, const Wrench& part) {
  return {total.force - part.force, total.torque - part.torque};
}

}  // namespace

void write_wrenches(const Joint& stated, const JointEquations& joint, const Eigen::Ref<const VecX>& lambda,
                    const SpringsAt* springs, JointWrenches& wrenches) {
  VecX& tau = wrenches.tau;
  tau.setZero(joint.n_u);
  for (std::size_t k = 0; k < stated.drivers.size(); ++k) {
    const Driver& driver = stated.drivers[k];
    tau(first_u(*stated.type, driver.word) + driver.component) =
        -lambda(joint.first_driver + static_cast<Eigen::Index>(k));
  }
  for (VecX& share : wrenches.shares) share.setZero(tau.size());
  wrenches.shares[index(Actor::driver)] = tau;
  for (std::size_t k = 0; k < joint.coupled.size(); ++k) {
    const CoupledCoordinate& coordinate = joint.coupled[k];
    tau(first_u(*stated.type, coordinate.word) + coordinate.component) -=
        lambda(joint.n_rows + static_cast<Eigen::Index>(k));
  }
  const bool is_driven = !stated.drivers.empty() || !joint.coupled.empty();
  const auto by_rows = is_driven ? coordinate_wrenches(stated, joint, tau) : std::array<Wrench, 2>{};
  const bool is_pushed = is_driven || springs != nullptr;
  if (springs != nullptr) {
    add_spring_shares(stated, joint, springs->t, springs->exerted, wrenches.shares);
    tau += springs->exerted.tau;
  }
  for (const Side side : {Side::parent, Side::child}) {
    const Marker& marker = joint.marker(side);
    // All rows, those of drivers and couplings included; springs stand among the applied forces.
    const Wrench of_rows = is_ground(body_of(stated.on(side)))
                               ? on_ground(joint, side, lambda)
                               : from_columns(marker, joint.Phi_Y_transposed[index(side)], lambda);
    Wrench total = of_rows;
    if (springs != nullptr) total += springs->exerted.wrenches[index(side)];
    wrenches.reaction[index(side)] = seen_from(marker.A_joint, difference(of_rows, by_rows[index(side)]));
    wrenches.total[index(side)] = is_pushed ? seen_from(marker.A_joint, total) : wrenches.reaction[index(side)];
  }
}

JointWrenches compute_wrenches(const Joint& stated, const JointEquations& joint, const Eigen::Ref<const VecX>& lambda,
                               const SpringsAt* springs) {
  JointWrenches wrenches;
  write_wrenches(stated, joint, lambda, springs, wrenches);
  return wrenches;
}

}  // namespace concord::cartesian
