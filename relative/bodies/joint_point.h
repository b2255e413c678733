#pragma once

#include "common/model.h"
#include "relative/bodies/mobilizer.h"
#include "relative/bodies/small_products.h"

/// Motion of a point and a frame on one body, where a joint or a force element sits, (R5) to (R7).
namespace concord::relative {

/// Pose and velocity of a body at its reference point, or at the origin of its frame where that is said; global axes.
struct BodyMotion {
  Vec3 r = Vec3::Zero();
  Mat3 A = Mat3::Identity();
  Vec3 v = Vec3::Zero();
  Vec3 omega = Vec3::Zero();
};

/// The point P and the joint frame of one side of one joint, or of one end of a force element. Velocity V_P = [v_P;
/// omega'] = G_P Y and acceleration Vdot_P = G_P Ydot + bias, with G_P = [1, -(A s)~, A Psi_t; 0, 1, A J Psi_r] and Y =
/// [v; omega; adot] of the body.
class JointPoint {
 public:
  /// `attachment` is seen from the body's reference point. `owner` is whose point it is, for messages: "joint 'A'" or
  /// "force element 'strut'".
  JointPoint(std::string owner, const Attachment& attachment);

  [[nodiscard]] int n_modes() const { return static_cast<int>(attachment_.Psi_t_L.cols()); }

  /// Takes the body's deformation: place, joint frame and tangent in body axes. Needs n_modes numbers each. Throws
  /// SolverError if the frame has turned by pi or more against the body. Does nothing on a rigid body.
  void deform(const double* a, const double* adot) {
    if (n_modes() > 0) deform_flexible(a, adot);
  }

  /// Point and joint frame from the body's motion, and Gdot_P Y (R5), (R6).
  void compute_point_motion(const BodyMotion& body) {
    multiply(body.A, C_, A);
    multiply(body.A, s_L_.data(), lever.data());
    r = body.r + lever;
    omega = body.omega;
    const Vec3 swing = cross(body.omega, lever);
    v = body.v + swing;
    bias.head<3>() = cross(body.omega, swing);
    if (n_modes() > 0) add_deformation(body);
  }

  /// The body's motion from that of the point and joint frame (members r, A, v, omega set by the caller) (R7).
  void compute_body_motion(BodyMotion& body) {
    multiply_transpose(A, C_, body.A);
    body.r = r;
    body.omega = omega;
    body.v = v;
    if (is_reference_point_) return;
    multiply(body.A, s_L_.data(), lever.data());
    body.r -= lever;
    if (n_modes() > 0) remove_deformation(body);
    const Vec3 swing = cross(body.omega, lever);
    body.v -= swing;
    bias.head<3>() = cross(body.omega, swing);
    if (n_modes() > 0) add_deformation_bias(body.omega);
  }

  /// Whether it is the reference point of a rigid body: lever and bias vanish.
  [[nodiscard]] bool is_reference_point() const { return is_reference_point_; }

  /// G_a = [A Psi_t; A J Psi_r], 6 x n_modes, global axes.
  [[nodiscard]] const Mat6X& Ga() const { return Ga_; }

  Vec3 r = Vec3::Zero();      // of P, m
  Mat3 A = Mat3::Identity();  // A' = A R(theta) C, joint frame to global
  Vec3 v = Vec3::Zero();      // of P, m/s
  Vec3 omega = Vec3::Zero();  // omega' of the joint frame, rad/s
  Vec3 lever = Vec3::Zero();  // A s_P, deformed, m
  Vec6 bias = Vec6::Zero();   // Gdot_P Y

 private:
  void deform_flexible(const double* a, const double* adot);
  void add_deformation(const BodyMotion& body);
  void remove_deformation(BodyMotion& body);
  void rotate_modes(const Mat3& body_A);
  void add_deformation_bias(const Vec3& body_omega);

  Attachment attachment_;
  std::string owner_;
  bool is_reference_point_;
  Vec3 s_L_;
  Mat3 C_;  // joint frame to body axes, deformed: R(theta) C
  Mat3X J_Psi_r_L_;
  Vec3 sdot_L_ = Vec3::Zero();       // Psi_t adot
  Vec3 turning_L_ = Vec3::Zero();    // J Psi_r adot
  Vec3 Jdot_rate_L_ = Vec3::Zero();  // Jdot Psi_r adot
  Vec3 sdot_ = Vec3::Zero();         // the same three in global axes
  Vec3 turning_ = Vec3::Zero();
  Vec3 Jdot_rate_ = Vec3::Zero();
  Mat6X Ga_;
};

}  // namespace concord::relative
