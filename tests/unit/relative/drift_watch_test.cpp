#include "relative/run/drift_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "machines.h"
#include "relative/run/adams.h"
#include "relative/run/integration_run.h"

namespace concord::relative {
namespace {

/// Whether a motion along one number passes `n` steps of length `way`, each of which the projection draws aside by
/// `aside(step)`; an error of 1e-10 is allowed.
template <class Aside>
bool passes(int n, double way, const Aside& aside) {
  DriftWatch watch(2);
  const VecX weights = VecX::Constant(2, 1e10);
  VecX projected = VecX::Zero(2);
  watch.stand_at(projected);
  for (int step = 0; step < n; ++step) {
    projected(0) += way;
    VecX reached = projected;
    reached(1) -= aside(step);
    if (!watch.pass(reached, projected, weights)) return false;
  }
  return true;
}

TEST(DriftWatch, TellsAMotionThatIsDrawnAsideFromErrorsOfIntegration) {
  EXPECT_TRUE(passes(300, 1e-2, [](int) { return 1e-10; }));
  EXPECT_FALSE(passes(100, 1e-2, [](int) { return 1e-6; }));
  EXPECT_TRUE(passes(99, 1e-2, [](int) { return 1e-6; }));                                // too early to tell
  EXPECT_TRUE(passes(300, 1e-2, [](int step) { return step % 2 == 0 ? 1e-6 : -1e-6; }));  // to and fro: round-off
  EXPECT_TRUE(passes(300, 1e2, [](int) { return 1e-6; }));                                // next to nothing of the way
  EXPECT_TRUE(passes(300, 1e-11, [](int) { return 1e-12; }));                             // below what is allowed
  EXPECT_FALSE(passes(250, 1e-2, [](int step) { return step < 100 ? 1e-10 : 1e-6; }));    // from some time on
}

/// A machine in a run, one of whose accelerations is off by a constant.
class Contradicted : public IntegratedSystem {
 public:
  Contradicted(IntegrationRun& run, Eigen::Index place, double off) : run_(run), place_(place), off_(off) {}
  void evaluate(double t, const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> ydot) override {
    run_.evaluate(t, y, ydot);
    ydot(place_) += off_;
  }
  void weigh(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> weights) const override { run_.weigh(y, weights); }
  void project(double t, Eigen::Ref<VecX> y) override { run_.project(t, y); }
  void differentiate(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                     Eigen::Ref<MatX> J) override {
    run_.differentiate(t, y, ydot, J);
  }
  void differentiate_modes(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<const VecX>& ydot,
                           Eigen::Ref<MatX> S, Eigen::Ref<MatX> D) override {
    run_.differentiate_modes(t, y, ydot, S, D);
  }

 private:
  IntegrationRun& run_;
  Eigen::Index place_;
  double off_;
};

/// Makes 20000 evaluations at most; what is said where the run ends before 0.2 s.
std::string end_of_run(double off, long& evaluations) {
  const Model model = test::spatial_slider_crank(false);
  Equations equations(model);
  Assembly assembly(equations);
  const Coordinates start = assembly.start();
  RunOptions options;
  options.until = 0.2;
  options.rtol = 1e-10;
  IntegrationRun run(equations, assembly, start, options, "adams");
  Contradicted system(run, run.variables().n_q(), off);
  VecX y = VecX::Zero(run.variables().size());
  run.variables().pack(start.q, start.u, y);
  Adams adams(system, run.modes(), y, {1e-3 * options.until, 2e-2 * options.until});
  std::string said = "creeps";
  try {
    while (adams.t() < options.until && run.evaluations() < 20000) adams.step(options.until);
    if (adams.t() >= options.until) said.clear();
  } catch (const SolverError& error) {
    said = error.what();
  }
  evaluations = run.evaluations();
  return said;
}

TEST(DriftWatch, EndsARunWhoseAccelerationsContradictTheConstraints) {
  long evaluations = 0;
  EXPECT_EQ(end_of_run(0.0, evaluations), "");
  EXPECT_THAT(end_of_run(0.3, evaluations),
              ::testing::MatchesRegex(
                  "the accelerations contradict the constraints, most of all the loop of joint '.+': the projection "
                  "onto these makes up [0-9.e+-]+ of the motion, where a motion that obeys them leaves it errors of "
                  "integration alone: a fault of the program, or of what a joint type or a law says of its own rates"));
  EXPECT_LT(evaluations, 1000);
}

}  // namespace
}  // namespace concord::relative
