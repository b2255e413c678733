#include "compare/audit/stated_derivatives.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/joints/catalogue.h"
#include "common/joints/screw.h"
#include "common/rotation.h"

namespace concord::compare {
namespace {

using joints::FunctionOfCoordinates;
using joints::FunctionOfPlacement;
using joints::JointType;
using joints::Placement;

/// What a function says, changed by a fault.
class SpoiledPlacement : public FunctionOfPlacement {
 public:
  SpoiledPlacement(std::shared_ptr<const FunctionOfPlacement> right, void (*spoil)(Rows&))
      : right_(std::move(right)), spoil_(spoil) {}
  [[nodiscard]] int n() const override { return right_->n(); }
  void evaluate(const Placement& at, const Vec6& v_rel, Rows& rows) const override {
    right_->evaluate(at, v_rel, rows);
    spoil_(rows);
  }

 private:
  std::shared_ptr<const FunctionOfPlacement> right_;
  void (*spoil_)(Rows&);
};

class SpoiledMotion : public FunctionOfCoordinates {
 public:
  SpoiledMotion(std::shared_ptr<const FunctionOfCoordinates> right, void (*spoil)(Motion&))
      : right_(std::move(right)), spoil_(spoil) {}
  [[nodiscard]] int n() const override { return right_->n(); }
  void evaluate(const double* q, const double* u, Motion& motion) const override {
    right_->evaluate(q, u, motion);
    spoil_(motion);
  }

 private:
  std::shared_ptr<const FunctionOfCoordinates> right_;
  void (*spoil_)(Motion&);
};

/// A pin on a curve whose height over the angle is a cubic spline: its third derivative jumps at angle 0.4.
struct CamMotion {
  template <class T>
  joints::PlacementOf<T> operator()(const joints::VectorOf<T, 1>& q) const {
    const T beyond = q(0) - T(0.4);
    const T lift = 0.02 * q(0) * q(0) + (beyond > T(0.0) ? T(0.3 * beyond * beyond * beyond) : T(0.0));
    return {joints::Vec3Of<T>(0.2 * cos(q(0)), 0.2 * sin(q(0)), lift), joints::rotation_by(Axis::z, q(0))};
  }
};
struct CamGap {
  template <class T>
  joints::VectorOf<T, 2> operator()(const joints::Vec3Of<T>& d, const joints::Mat3Of<T>& R) const {
    return {hypot(d.x(), d.y()) - 0.2, R(0, 2) * d.z() + R(1, 2)};
  }
};
struct CamReading {
  template <class T>
  joints::VectorOf<T, 1> operator()(const joints::Vec3Of<T>& d, const joints::Mat3Of<T>&) const {
    return joints::VectorOf<T, 1>(atan2(d.y(), d.x()));
  }
};

JointType cam() {
  return {.name = "cam",
          .forbids = {joints::ByResidual{joints::function_of_placement(CamGap{})}},
          .permits = {joints::ByMotion{joints::function_of_coordinates<1>(CamMotion{}), {true}, {"cam"}}},
          .reads = {joints::ByReading{joints::function_of_placement(CamReading{}), {true}}}};
}

/// The worst digits of each derivative of a type where its coordinates are q and its speeds u, near its motion.
std::vector<double> digits_of(const JointType& type, const VecX& q, const VecX& u) {
  const auto& motion_word = std::get<joints::ByMotion>(type.permits.front());
  FunctionOfCoordinates::Motion at;
  motion_word.motion->evaluate(q.data(), u.data(), at);
  RelativeMotion relative{at.placement.d, at.placement.R, at.S.leftCols(q.size()) * u};
  JointMotion motion;
  motion.q = q;
  motion.u = u;
  std::vector<double> digits;
  for (const StatedDerivative& found : compute_stated_derivatives(type, relative, motion, 0.7)) {
    digits.push_back(found.misfit == 0.0 ? 16.0 : -std::log10(found.misfit / found.scale));
  }
  return digits;
}

TEST(StatedDerivatives, OfTheCataloguesTypesAreThoseByDifferences) {
  for (const JointType* type : joints::catalogue()) {
    if (stated_derivatives(*type).empty()) continue;
    const VecX q = VecX::Constant(type->n_q(), 0.8);
    const VecX u = VecX::Constant(type->n_u(), -2.3);
    const std::vector<double> digits = digits_of(*type, q, u);
    ASSERT_EQ(digits.size(), stated_derivatives(*type).size());
    for (std::size_t k = 0; k < digits.size(); ++k) EXPECT_GT(digits[k], 9.0) << type->name << ' ' << k;
  }
  EXPECT_TRUE(stated_derivatives(*joints::find("universal")).empty());
}

TEST(StatedDerivatives, AKinkOfTheThirdOneAndAPoseAtHalfATurnAreNoFaults) {
  for (const double angle : {0.4, 0.4 - 1e-6, 0.4 + 1e-5, 0.39, 3.14159265, 3.15}) {
    const std::vector<double> digits = digits_of(cam(), VecX::Constant(1, angle), VecX::Constant(1, 30.0));
    ASSERT_EQ(digits.size(), 6U);
    for (std::size_t k = 0; k < digits.size(); ++k) EXPECT_GT(digits[k], 8.0) << angle << ", derivative " << k;
  }
}

TEST(StatedDerivatives, AWrongOneIsSeenAndNoOther) {
  using Rows = FunctionOfPlacement::Rows;
  using Motion = FunctionOfCoordinates::Motion;
  const JointType right = cam();
  const auto motion_with = [&](void (*spoil)(Motion&)) {
    JointType type = right;
    auto& word = std::get<joints::ByMotion>(type.permits.front());
    word.motion = std::make_shared<SpoiledMotion>(word.motion, spoil);
    return type;
  };
  const auto residual_with = [&](void (*spoil)(Rows&)) {
    JointType type = right;
    auto& word = std::get<joints::ByResidual>(type.forbids.front());
    word.residual = std::make_shared<SpoiledPlacement>(word.residual, spoil);
    return type;
  };
  const auto reading_with = [&](void (*spoil)(Rows&)) {
    JointType type = right;
    auto& word = std::get<joints::ByReading>(type.reads.front());
    word.reading = std::make_shared<SpoiledPlacement>(word.reading, spoil);
    return type;
  };
  // In the order of the derivatives; a wrong slope of the motion shows in the rate of S too.
  const std::vector<JointType> spoiled{motion_with([](Motion& motion) { motion.S(1, 0) *= 1.0001; }),
                                       motion_with([](Motion& motion) { motion.Sdot_u(2) *= 1.0001; }),
                                       residual_with([](Rows& rows) { rows.gradient(3, 1) += 1e-4; }),
                                       residual_with([](Rows& rows) { rows.bias(0) *= 1.0001; }),
                                       reading_with([](Rows& rows) { rows.gradient(0, 0) *= 1.0001; }),
                                       reading_with([](Rows& rows) { rows.bias(0) += 1e-4 * rows.bias.norm() + 0.1; })};
  for (std::size_t fault = 0; fault < spoiled.size(); ++fault) {
    const std::vector<double> digits = digits_of(spoiled[fault], VecX::Constant(1, 0.9), VecX::Constant(1, -3.0));
    for (std::size_t k = 0; k < digits.size(); ++k) {
      if (k == fault) {
        EXPECT_LT(digits[k], 6.0) << "fault " << fault;
      } else if (k != fault + 1 || fault % 2 == 1) {
        EXPECT_GT(digits[k], 8.0) << "fault " << fault << ", derivative " << k;
      }
    }
  }
}

}  // namespace
}  // namespace concord::compare
