#include "tests/second_reading/stated_motions.h"

#include <Eigen/Geometry>
#include <array>
#include <map>

namespace concord::second_reading {

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

Placement turn(const Mat3& R) { return {Vec3::Zero(), R}; }
Placement slide(const Vec3& d) { return {d, Mat3::Identity()}; }

using Motion = Placement (*)(const Numbers& numbers, const VecX& q);
using Motions = std::map<std::string, Motion>;

/// Rows of the page's table of types: without an arm.
Motions motions_about_a_point() {
  return {
      {"weld", [](const Numbers&, const VecX&) { return turn(Mat3::Identity()); }},
      {"revolute", [](const Numbers&, const VecX& q) { return turn(turned(kZ, q(0))); }},
      {"translational",
       [](const Numbers&, const VecX& q) {
         return slide({0, 0, q(0)});
       }},
      {"cylindrical",
       [](const Numbers&, const VecX& q) {
         return Placement{Vec3(0, 0, q(0)), turned(kZ, q(1))};
       }},
      {"spherical", [](const Numbers&, const VecX& q) { return turn(ball(q, 0)); }},
      {"universal", [](const Numbers&, const VecX& q) { return turn(turned(kX, q(0)) * turned(kY, q(1))); }},
      {"free",
       [](const Numbers&, const VecX& q) {
         return Placement{q.head<3>(), ball(q, 3)};
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
}

/// And with an arm of its length.
Motions motions_of_arms() {
  return {
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
  };
}

}  // namespace

std::optional<Placement> stated_placement(const std::string& type, const Numbers& numbers, const VecX& q) {
  static const std::array all{motions_about_a_point(), motions_of_arms()};
  for (const Motions& motions : all) {
    if (const auto found = motions.find(type); found != motions.end()) return found->second(numbers, q);
  }
  return std::nullopt;
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

}  // namespace concord::second_reading
