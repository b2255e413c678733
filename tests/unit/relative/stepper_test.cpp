#include "relative/run/stepper.h"

#include <arkode/arkode.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace concord::relative {
namespace {

constexpr double kUnitRoundOff = std::numeric_limits<double>::epsilon();

/// y' = cos t.
int rate(realtype t, N_Vector /*y*/, N_Vector ydot, void* /*data*/) {
  NV_Ith_S(ydot, 0) = std::cos(t);
  return 0;
}

int keep(realtype /*t*/, N_Vector /*y*/, void* /*data*/) { return 0; }

int weigh(N_Vector y, N_Vector weights, void* /*data*/) {
  NV_Ith_S(weights, 0) = 1.0 / (1e-9 * std::abs(NV_Ith_S(y, 0)) + 1e-12);
  return 0;
}

/// Samples and points of tables may lie next to the end of a step: there ARKODE refuses to go on, or says that it has
/// arrived without a step, whose length may not be counted again.
TEST(Stepper, StopsBesideTheEndOfAStepMoveNeitherTimeNorState) {
  const sundials::Context context;
  for (const double apart : {1.0, 3.0, 10.0, 40.0, 90.0, 120.0, 150.0}) {  // round-off of the time
    sundials::MessageRecord messages;
    const sundials::Vector y = sundials::make_vector(1, context);
    Stepper stepper("erk", y.get(), {rate, keep, weigh, nullptr, nullptr}, context, messages);
    const auto beside = [&](double t) { return t + apart * kUnitRoundOff * t; };
    double t = 0.0;
    for (int k = 1; t < 2.0; ++k) {
      ASSERT_GE(stepper.step(2.0, y.get(), t), 0) << apart << ": " << messages.last;
      const double end = beside(t);
      ASSERT_GE(stepper.advance(end, y.get(), t), 0) << apart << ", after " << k << " steps: " << messages.last;
      ASSERT_EQ(t, end);
      if (k % 5 == 0) {
        ASSERT_GE(stepper.restart(t, y.get(), 1e-2), 0);
        ASSERT_GE(stepper.advance(beside(t), y.get(), t), 0) << apart << ", anew: " << messages.last;
      }
      ASSERT_LT(k, 2000);
    }
    EXPECT_NEAR(NV_Ith_S(y.get(), 0), std::sin(t), 1e-8) << apart;
  }
}

}  // namespace
}  // namespace concord::relative
