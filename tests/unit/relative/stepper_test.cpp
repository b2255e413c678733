#include "relative/run/stepper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "relative/run/adams.h"
#include "relative/run/implicit_stepper.h"

namespace concord::relative {
namespace {

constexpr double kUnitRoundOff = std::numeric_limits<double>::epsilon();

/// y' = cos t.
struct Swing : IntegratedSystem {
  void evaluate(double t, const Eigen::Ref<const VecX>& /*y*/, Eigen::Ref<VecX> ydot) override {
    ydot(0) = std::cos(t);
  }
  void weigh(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> weights) const override {
    weights(0) = 1.0 / (1e-9 * std::abs(y(0)) + 1e-12);
  }
  void project(double /*t*/, Eigen::Ref<VecX> /*y*/) override {}
  void differentiate(double, const Eigen::Ref<const VecX>&, const Eigen::Ref<const VecX>&,
                     Eigen::Ref<MatX> J) override {
    J.setZero();
  }
  void differentiate_modes(double, const Eigen::Ref<const VecX>&, const Eigen::Ref<const VecX>&, Eigen::Ref<MatX>,
                           Eigen::Ref<MatX>) override {}
};

std::unique_ptr<Stepper> stepper_of(const std::string& name, IntegratedSystem& system) {
  if (name == "dirk") return std::make_unique<ImplicitStepper>(system, VecX::Zero(1));
  return std::make_unique<Adams>(system, ModalOscillators({}, {}, VecX()), VecX::Zero(1), Adams::Lengths{1e-3, 0.1});
}

/// Samples and points of tables may lie next to the end of a step: there ARKODE refuses to go on, or says that it has
/// arrived without a step, whose length may not be counted again.
TEST(Stepper, StopsBesideTheEndOfAStepMoveNeitherTimeNorState) {
  for (const std::string name : {"adams", "dirk"}) {
    const int often = name == "adams" ? 25 : 1;  // a stop ends what a multistep method knows
    for (const double apart : {1.0, 3.0, 10.0, 40.0, 90.0, 120.0, 150.0}) {  // round-off of the time
      Swing system;
      const std::unique_ptr<Stepper> stepper = stepper_of(name, system);
      const auto to_beside = [&] {
        const double end = stepper->t() + apart * kUnitRoundOff * stepper->t();
        while (stepper->t() < end) stepper->step(end);
        ASSERT_EQ(stepper->t(), end) << name << " " << apart;
      };
      for (int k = 1; stepper->t() < 2.0; ++k) {
        stepper->step(2.0);
        if (k % often != 0) continue;
        to_beside();
        if (k % (5 * often) == 0) {
          stepper->restart(1e-2);
          to_beside();
        }
        ASSERT_LT(k, 2000);
      }
      EXPECT_NEAR(stepper->y()(0), std::sin(stepper->t()), 1e-8) << name << " " << apart;
    }
  }
}

}  // namespace
}  // namespace concord::relative
