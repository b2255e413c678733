#pragma once

#include <memory>
#include <utility>

#include "common/joints/functions.h"
#include "common/joints/jet.h"
#include "common/types.h"

/// How a page states a joint by functions: as generic functions of any scalar type. The derivatives that the solvers
/// need follow exactly, by forward automatic differentiation; a page never writes one.
///
///   const auto on_the_circle = function_of_placement(
///       []<class T>(const Vec3Of<T>& d, const Mat3Of<T>&) { return VectorOf<T, 2>(d.head(2).norm() - 0.3, d.z()); });
///   const auto round_the_circle = function_of_coordinates<1>(
///       []<class T>(const VectorOf<T, 1>& q) { return PlacementOf<T>{Vec3Of<T>(0.3 * cos(q(0)), 0.3 * sin(q(0)), 0.0),
///                                                                    rotation_by(Axis::z, q(0))}; });
///
/// Call sin, cos, sqrt, atan2, ... without std::, and give intermediate vectors their type instead of `auto`, because
/// Eigen's expressions refer to their operands.
namespace concord::joints {

template <class T, int n>
using VectorOf = Eigen::Matrix<T, n, 1>;
template <class T>
using Vec3Of = Eigen::Matrix<T, 3, 1>;
template <class T>
using Mat3Of = Eigen::Matrix<T, 3, 3>;

/// Position and orientation of the child in the parent's joint frame, in numbers of any kind.
template <class T>
struct PlacementOf {
  Vec3Of<T> d;
  Mat3Of<T> R;
};

/// Rotation about a coordinate axis by an angle [rad], right-handed.
template <class T>
Mat3Of<T> rotation_by(Axis axis, const T& angle) {
  const int first = index(axis);
  const int second = (first + 1) % 3;
  const int third = (first + 2) % 3;
  Mat3Of<T> R = Mat3Of<T>::Identity();
  R(second, second) = R(third, third) = cos(angle);
  R(third, second) = sin(angle);
  R(second, third) = -sin(angle);
  return R;
}

/// The placement on its way with relative velocity v_rel = [ddot; omega_rel] and a_rel = 0: derivatives over the six
/// directions [d; rho], dR = rho~ R, and along the motion (S18).
PlacementOf<Jet> moving(const Placement& at, const Vec6& v_rel);

/// The motion of a placement whose jets are derivatives over n coordinates q and along their motion: columns of S are
/// [dd/dq_k; axis of (dR/dq_k) R^T], Sdot_u likewise from the second derivatives along the motion.
void write_motion(const PlacementOf<Jet>& reached, int n, FunctionOfCoordinates::Motion& motion);

/// Six functions at most, with `F` called as f(d, R) on jets.
template <class F>
class DifferentiatedPlacement final : public FunctionOfPlacement {
  using Values =
      decltype(std::declval<const F&>()(std::declval<const Vec3Of<Jet>&>(), std::declval<const Mat3Of<Jet>&>()));
  static constexpr int kCount = Values::RowsAtCompileTime;
  static_assert(kCount >= 1 && kCount <= 6 && Values::ColsAtCompileTime == 1,
                "a function of the placement returns a VectorOf<T, n> with n from 1 to 6");

 public:
  explicit DifferentiatedPlacement(F f) : f_(std::move(f)) {}

  [[nodiscard]] int n() const override { return kCount; }

  void evaluate(const Placement& at, const Vec6& v_rel, Rows& rows) const override {
    const PlacementOf<Jet> placement = moving(at, v_rel);
    const VectorOf<Jet, kCount> values = f_(placement.d, placement.R);
    rows.n = kCount;
    for (int k = 0; k < kCount; ++k) {
      rows.value(k) = values(k).value;
      rows.gradient.col(k) = values(k).gradient;
      rows.bias(k) = values(k).rate_of_rate;
    }
  }

 private:
  F f_;
};

/// A motion with `F` called as f(q) on jets.
template <int count, class F>
class DifferentiatedMotion final : public FunctionOfCoordinates {
  static_assert(count >= 1 && count <= 6, "a motion by functions has one to six coordinates");

 public:
  explicit DifferentiatedMotion(F f) : f_(std::move(f)) {}

  [[nodiscard]] int n() const override { return count; }

  void evaluate(const double* q, const double* u, Motion& motion) const override {
    VectorOf<Jet, count> moving_q;
    for (int k = 0; k < count; ++k) moving_q(k) = Jet(q[k], Vec6::Unit(k), u[k], 0.0);
    const PlacementOf<Jet> reached = f_(moving_q);
    write_motion(reached, count, motion);
  }

 private:
  F f_;
};

/// Functions c(d, R) from a generic function []<class T>(const Vec3Of<T>& d, const Mat3Of<T>& R) that returns
/// VectorOf<T, n>.
template <class F>
std::shared_ptr<const FunctionOfPlacement> function_of_placement(F f) {
  return std::make_shared<DifferentiatedPlacement<F>>(std::move(f));
}

/// A motion q -> (d, R) with `count` coordinates from a generic function []<class T>(const VectorOf<T, count>& q) that
/// returns PlacementOf<T>; R a rotation for every q.
template <int count, class F>
std::shared_ptr<const FunctionOfCoordinates> function_of_coordinates(F f) {
  return std::make_shared<DifferentiatedMotion<count, F>>(std::move(f));
}

}  // namespace concord::joints
