#include "compare/resolution/run_check.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

// A run by one solver, beside a scale that is infinite, would hold every audit.
TEST(RunCheck, RefusesNumbersWhoseSquaresOverflow) {
  const Model model = pendulum_model();
  const QuantityLayout layout(model);
  FakePendulum solver(model, "cartesian");
  const RunOptions options{0.2, 1e-11, 20, ""};
  Trajectory run = solver.integrate(options, [](double) {});
  run.samples[3].evaluation.joints[0].reaction[1].in_C.force(1) = 1e160;
  std::string said = "nothing";
  try {
    (void)check_run(layout, solver, run, options);
  } catch (const IncompleteResult& error) {
    said = error.what();
  }
  EXPECT_EQ(said, "cartesian: joint A on bob, F_y is 1e+160, beyond the 1e+150 that can be judged, at t = 0.03 s");
}

}  // namespace
}  // namespace concord::compare
