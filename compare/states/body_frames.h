#pragma once

#include <functional>

#include "common/model.h"
#include "common/results.h"

/// Bodies in frames that lie elsewhere in them than the model says. What is physical stays.
namespace concord::compare {

/// A body whose frame is moved: `frame` is the new one seen from the old one.
Body with_frame(Body body, const Pose& frame);
Attachment with_frame(Attachment side, const Pose& frame);

/// The motion of the frame that lies at `frame` in a body's frame, or of the latter given the former's.
BodyState moved_motion(BodyState body, const Pose& frame);

/// The acceleration of a frame's origin [m/s2] -> that of the point from which `arm` [m] leads to it, in a body that
/// moves so.
void take_arm_off(const Vec3& arm, const Vec3& omega, BodyAcceleration& body);

/// Every attachment of joints and force elements.
void for_each_attachment(Model& model, const std::function<void(Attachment&)>& edit);
void for_each_attachment(const Model& model, const std::function<void(const Attachment&)>& look);

/// Euler parameters of a rotation, scalar first.
Vec4 euler_parameters_of(const Mat3& A);

}  // namespace concord::compare
