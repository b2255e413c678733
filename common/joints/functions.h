#pragma once

#include <memory>

#include "common/types.h"

/// Joints that are given by functions of (d, R) or of q. A page writes each as a generic function of any scalar type,
/// see by_function.h; here is what the solvers see of them: values with first derivatives, and second ones along the
/// motion.
namespace concord::joints {

/// Position and orientation of the child in the parent's joint frame (S10).
struct Placement {
  Vec3 d = Vec3::Zero();
  Mat3 R = Mat3::Identity();
};

/// Wrenches [F; T], one in each of at most six columns, without heap memory.
using Wrenches = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;
using WrenchesOfPlacement = Wrenches (*)(const Placement& at);

/// At most six functions c(d, R) (S11), (S18).
class FunctionOfPlacement {
 public:
  /// Values, gradients (column k over [d; rho], dR = rho~ R) and biases: cddot = gradient . a_rel + bias along a motion
  /// with relative velocity v_rel = [ddot; omega_rel].
  struct Rows {
    int n = 0;
    Vec6 value = Vec6::Zero();
    Mat6 gradient = Mat6::Zero();
    Vec6 bias = Vec6::Zero();
  };

  virtual ~FunctionOfPlacement() = default;
  [[nodiscard]] virtual int n() const = 0;
  virtual void evaluate(const Placement& at, const Vec6& v_rel, Rows& rows) const = 0;
};

/// A motion q -> (d, R) with at most six coordinates; speeds u = qdot.
class FunctionOfCoordinates {
 public:
  /// (d, R), S with v_rel = S qdot (n columns), and Sdot qdot.
  struct Motion {
    Placement placement;
    Mat6 S = Mat6::Zero();
    Vec6 Sdot_u = Vec6::Zero();
  };

  virtual ~FunctionOfCoordinates() = default;
  [[nodiscard]] virtual int n() const = 0;
  virtual void evaluate(const double* q, const double* u, Motion& motion) const = 0;
};

}  // namespace concord::joints
