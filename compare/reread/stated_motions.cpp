#include "compare/reread/stated_motions.h"

#include <Eigen/Geometry>
#include <map>

namespace concord::compare::reread {

namespace {

using joints::Placement;
using Numbers = std::vector<double>;

Mat3 turned(int axis, double angle) { return Eigen::AngleAxisd(angle, Vec3::Unit(axis)).toRotationMatrix(); }

/// The orientation of a ball, whose four Euler parameters begin at q(k).
Mat3 ball(const VecX& q, int k) {
  return Eigen::Quaterniond(q(k), q(k + 1), q(k + 2), q(k + 3)).normalized().toRotationMatrix();
}

constexpr int kX = 0;
constexpr int kY = 1;
constexpr int kZ = 2;

using Motion = Placement (*)(const Numbers& numbers, const VecX& q);

/// The rows of the page's table of types.
const std::map<std::string, Motion>& motions() {
  static const std::map<std::string, Motion> all{
      {"weld",
       [](const Numbers&, const VecX&) {
         return Placement{Vec3::Zero(), Mat3::Identity()};
       }},
      {"revolute",
       [](const Numbers&, const VecX& q) {
         return Placement{Vec3::Zero(), turned(kZ, q(0))};
       }},
      {"translational",
       [](const Numbers&, const VecX& q) {
         return Placement{Vec3(0, 0, q(0)), Mat3::Identity()};
       }},
      {"cylindrical",
       [](const Numbers&, const VecX& q) {
         return Placement{Vec3(0, 0, q(0)), turned(kZ, q(1))};
       }},
      {"spherical",
       [](const Numbers&, const VecX& q) {
         return Placement{Vec3::Zero(), ball(q, 0)};
       }},
      {"universal",
       [](const Numbers&, const VecX& q) {
         return Placement{Vec3::Zero(), turned(kX, q(0)) * turned(kY, q(1))};
       }},
      {"free",
       [](const Numbers&, const VecX& q) {
         return Placement{q.head<3>(), ball(q, 3)};
       }},
      {"distance",
       [](const Numbers& length, const VecX& q) {
         return Placement{turned(kX, q(0)) * turned(kY, q(1)) * Vec3(0, 0, length[0]), ball(q, 2)};
       }},
      {"revolute_spherical",
       [](const Numbers& length, const VecX& q) {
         return Placement{turned(kZ, q(0)) * Vec3(length[0], 0, 0), ball(q, 1)};
       }},
      {"universal_spherical",
       [](const Numbers& length, const VecX& q) {
         return Placement{turned(kY, q(0)) * turned(kZ, q(1)) * Vec3(length[0], 0, 0), ball(q, 2)};
       }},
      {"knife_edge",
       [](const Numbers&, const VecX& q) {
         return Placement{Vec3(q(0), q(1), 0), turned(kZ, q(2))};
       }},
      {"rolling_ball",
       [](const Numbers&, const VecX& q) {
         return Placement{Vec3(q(0), q(1), 0), ball(q, 2)};
       }},
      {"screw",
       [](const Numbers& lead, const VecX& q) {
         return Placement{Vec3(0, 0, lead[0] * q(0)), turned(kZ, q(0))};
       }},
  };
  return all;
}

}  // namespace

std::optional<Placement> stated_placement(const std::string& type, const Numbers& numbers, const VecX& q) {
  const auto found = motions().find(type);
  if (found == motions().end()) return std::nullopt;
  return found->second(numbers, q);
}

std::optional<StatedSpeeds> stated_speeds(const std::string& type, const Numbers& numbers, const Mat3& R) {
  StatedSpeeds speeds;
  if (type == "knife_edge") {
    // It stays upright on the plane, and its point does not move along the child's y.
    speeds.n = 2;
    speeds.forbidden = MatX::Zero(4, 6);
    speeds.forbidden.row(0).head<3>() = R.col(kY).transpose();
    speeds.forbidden(1, kZ) = speeds.forbidden(2, 3 + kX) = speeds.forbidden(3, 3 + kY) = 1.0;
    return speeds;
  }
  if (type == "rolling_ball") {
    // Its centre stays in its plane, and its lowest point, `radius` below, rests: ddot + omega x (0, 0, -radius) = 0.
    speeds.n = 3;
    speeds.forbidden = MatX::Zero(3, 6);
    speeds.forbidden.leftCols<3>().setIdentity();
    speeds.forbidden(0, 3 + kY) = -numbers[0];
    speeds.forbidden(1, 3 + kX) = numbers[0];
    return speeds;
  }
  return std::nullopt;
}

}  // namespace concord::compare::reread
