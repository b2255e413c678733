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

/// Every attachment of joints and force elements.
void for_each_attachment(Model& model, const std::function<void(Attachment&)>& edit);

/// Euler parameters of a rotation, scalar first.
Vec4 euler_parameters_of(const Mat3& A);

}  // namespace concord::compare
