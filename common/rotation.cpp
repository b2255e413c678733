#include "common/rotation.h"

#include <Eigen/Geometry>

namespace concord {

Mat3 skew(const Vec3& v) {
  Mat3 result;
  result << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return result;
}

Mat3 rotation_about(const Vec3& axis, double angle) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }

Mat3 rotation_about(Axis axis, double angle) { return rotation_about(Vec3(Vec3::Unit(index(axis))), angle); }

Mat3 rotation_from_x_and_z(const Vec3& x, const Vec3& z) {
  Mat3 result;
  result << x, z.cross(x), z;
  return result;
}

}  // namespace concord
