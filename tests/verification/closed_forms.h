#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "common/rotation.h"
#include "compare/audit/digits.h"
#include "compare/states/branch.h"
#include "relative/solver.h"

/// Tools of the closed-form cases: both solvers in turn, exact functions, agreement in digits. No mechanics of a
/// solver.
namespace concord::verification {

inline Model read(const std::string& name) {
  return read_model(std::filesystem::path(CONCORD_DATA) / "models" / (name + ".toml"));
}

inline Model parse(const std::string& text) { return parse_model(text, "closed_form.toml"); }

inline const compare::SolverMakers kMakers{cartesian::make_solver, relative::make_solver};

/// Both solvers of a model, which must outlive them.
inline std::vector<std::unique_ptr<Solver>> both_solvers(const Model& model) {
  std::vector<std::unique_ptr<Solver>> solvers;
  solvers.push_back(cartesian::make_solver(model));
  solvers.push_back(relative::make_solver(model));
  return solvers;
}

/// A run with the solver's default integrator, or a named one.
inline Trajectory run(Solver& solver, double until, double rtol, int samples, const std::string& integrator = "") {
  return solver.integrate({until, rtol, samples, integrator}, {});
}

/// A = (e0^2 - e.e) 1 + 2 e e^T + 2 e0 e~.
inline Mat3 rotation_of(const Vec4& p) {
  const Vec3 e = p.tail<3>();
  return (p(0) * p(0) - e.squaredNorm()) * Mat3::Identity() + 2.0 * e * e.transpose() + 2.0 * p(0) * skew(e);
}

inline Wrench rotated(const Mat3& A, const Wrench& wrench) { return {A * wrench.force, A * wrench.torque}; }

/// The same machine in a world turned by Q, gravity with it.
inline Model turn_world(Model model, const Mat3& Q) {
  const auto turn = [&](std::array<Attachment, 2>& ends) {
    for (Attachment& end : ends) {
      if (end.body != kGround) continue;
      end.point_L = Q * end.point_L;
      end.C = Q * end.C;
    }
  };
  model.gravity = Q * model.gravity;
  for (Joint& joint : model.joints) turn(joint.sides);
  for (ForceElement& element : model.elements) {
    if (auto* spring = std::get_if<LineSpring>(&element.what)) turn(spring->ends);
    if (auto* spring = std::get_if<TurnSpring>(&element.what)) turn(spring->ends);
    if (auto* bushing = std::get_if<Bushing>(&element.what)) turn(bushing->ends);
  }
  return model;
}

/// Agreement of a series of numbers or vectors with their exact values: the largest difference over the largest value.
class Agreement {
 public:
  template <class Value>
  void add(const Value& found, const Value& exact) {
    if constexpr (std::is_arithmetic_v<Value>) {
      take(std::abs(found - exact), std::abs(exact));
    } else {
      take((found - exact).norm(), exact.norm());
    }
  }
  [[nodiscard]] double digits() const { return compare::matching_digits(difference_, scale_); }

 private:
  void take(double difference, double size) {
    difference_ = std::isnan(difference) ? difference : std::max(difference_, difference);
    scale_ = std::max(scale_, size);
  }
  double difference_ = 0.0;
  double scale_ = 0.0;
};

/// Agreement of the wrenches of one joint: forces on the joint's peak |F|, torques on max(peak |T|, peak |F| l).
class WrenchAgreement {
 public:
  explicit WrenchAgreement(double length) : length_(length) {}

  void add(const Wrench& found, const Wrench& exact) {
    force_error_ = worse(force_error_, (found.force - exact.force).lpNorm<Eigen::Infinity>());
    torque_error_ = worse(torque_error_, (found.torque - exact.torque).lpNorm<Eigen::Infinity>());
    force_ = std::max(force_, exact.force.norm());
    torque_ = std::max(torque_, exact.torque.norm());
  }
  [[nodiscard]] double digits() const {
    return std::min(compare::matching_digits(force_error_, force_),
                    compare::matching_digits(torque_error_, std::max(torque_, force_ * length_)));
  }

 private:
  static double worse(double kept, double error) { return std::isnan(error) ? error : std::max(kept, error); }

  double length_;
  double force_error_ = 0.0;
  double torque_error_ = 0.0;
  double force_ = 0.0;
  double torque_ = 0.0;
};

/// What was measured, for the reader of the test's output.
inline void tell(std::string_view what, const Solver& solver, double digits) {
  fmt::print("{:<58} {:<10} {:>5} digits\n", what, solver.name(), compare::format_digits(digits));
}

/// Jacobi's elliptic functions of modulus k, 0 <= k < 1.
struct Jacobi {
  double am, sn, cn, dn;
};

/// By the arithmetic-geometric mean and the descending Landen transformation (Abramowitz and Stegun 16.4); am is
/// continuous in u.
inline Jacobi jacobi(double u, double k) {
  std::vector<double> a{1.0};
  std::vector<double> c{k};
  double b = std::sqrt((1.0 - k) * (1.0 + k));
  while (std::abs(c.back()) > 1e-17 && a.size() < 12) {
    const double mean = 0.5 * (a.back() + b);
    c.push_back(0.5 * (a.back() - b));
    b = std::sqrt(a.back() * b);
    a.push_back(mean);
  }
  double am = std::ldexp(a.back() * u, static_cast<int>(a.size()) - 1);
  for (std::size_t n = a.size() - 1; n > 0; --n) am = 0.5 * (am + std::asin(c[n] * std::sin(am) / a[n]));
  return {am, std::sin(am), std::cos(am), std::sqrt(1.0 - k * k * std::sin(am) * std::sin(am))};
}

/// Wrench that turns a rigid body about the z axis of its joint frame at the rates omega, alpha: on the body at the
/// joint's point, in its joint frame, by Newton's and Euler's laws. The joint's point rests; gravity in the same frame.
inline Wrench hinge_wrench(const Body& body, const Attachment& side, const Vec3& gravity_C, double omega,
                           double alpha) {
  const Vec3 s = side.C.transpose() * (body.center_of_mass_L - side.point_L);
  const Mat3 I = side.C.transpose() * body.inertia_L * side.C +
                 body.mass * (s.squaredNorm() * Mat3::Identity() - s * s.transpose());
  const Vec3 z = Vec3::UnitZ();
  const Vec3 acceleration = alpha * z.cross(s) + omega * omega * z.cross(z.cross(s));
  const Vec3 Iz = I * z;
  return {body.mass * (acceleration - gravity_C),
          alpha * Iz + omega * omega * z.cross(Iz) - body.mass * s.cross(gravity_C)};
}

}  // namespace concord::verification
