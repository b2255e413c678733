#include <catch2/catch.hpp>

#include "closed_forms.h"

/// One machine told with other joints: the reactions that both tellings have must be the same, or become so as the
/// inertia vanishes that one of them has more.
namespace concord::verification {
namespace {

/// What two models have in common: a reaction, or all that passes through a joint.
struct Common {
  int first;   // joint of one model
  int second;  // joint of the other
  Side side;
  enum { reaction, total } what = reaction;

  [[nodiscard]] const Wrench& of(const JointWrenches& joint) const {
    return (what == reaction ? joint.reaction_on(side) : joint.total_on(side)).in_global;
  }
};

/// How far two runs agree: the worst of the wrenches that they have in common.
double agreement(const Trajectory& one, const Trajectory& other, const std::vector<Common>& common) {
  double worst = 16.0;
  for (const Common& pair : common) {
    WrenchAgreement wrench(0.3);
    for (std::size_t k = 0; k < one.samples.size(); ++k) {
      wrench.add(pair.of(other.samples[k].evaluation.joints[pair.second]),
                 pair.of(one.samples[k].evaluation.joints[pair.first]));
    }
    worst = std::min(worst, wrench.digits());
  }
  return worst;
}

Trajectory short_run(Solver& solver) { return run(solver, 0.5, 1e-12, 50); }

Model with_mass(Model model, int body, double factor) {
  model.bodies[body].mass *= factor;
  model.bodies[body].inertia_L *= factor;
  return model;
}

/// Agreement with the twin whose body 2 has its inertia times 1, 1/100, 1/10000: each step gains two digits.
void check_convergence(const std::string& what, const std::string& name, const std::string& twin,
                       const std::vector<Common>& common) {
  const Model model = read(name);
  for (std::size_t which = 0; which < 2; ++which) {
    const auto solver = std::move(both_solvers(model)[which]);
    INFO(what << ", " << solver->name());
    const Trajectory reference = short_run(*solver);
    std::vector<double> digits;
    for (const double factor : {1.0, 1e-2, 1e-4}) {
      const Model massive = with_mass(read(twin), 2, factor);
      digits.push_back(agreement(reference, short_run(*both_solvers(massive)[which]), common));
    }
    tell(what + ", 0.1 g between", *solver, digits[0]);
    tell(what + ", 1 mg", *solver, digits[1]);
    tell(what + ", 10 ug", *solver, digits[2]);
    CHECK(digits[0] >= 3.0);
    CHECK(digits[1] - digits[0] == Approx(2.0).margin(0.1));
    CHECK(digits[2] - digits[1] == Approx(2.0).margin(0.1));
  }
}

}  // namespace

TEST_CASE("Two hinges on a cross carry what a universal joint does, as the inertia of the cross vanishes",
          "[closed form][equivalents][quick]") {
  check_convergence("universal joint as two hinges", "universal_in_a_pendulum", "cross_in_a_pendulum",
                    {{0, 0, Side::parent}, {0, 0, Side::child}, {1, 1, Side::parent}, {1, 2, Side::child}});
}

TEST_CASE("A slide and a hinge on a sleeve carry what a cylindrical joint does, as the inertia of the sleeve vanishes",
          "[closed form][equivalents][quick]") {
  check_convergence("cylindrical joint as slide and hinge", "cylindrical_in_a_pendulum", "sleeve_in_a_pendulum",
                    {{0, 0, Side::parent},
                     {0, 0, Side::child},
                     {1, 1, Side::parent},
                     {1, 1, Side::parent, Common::total},
                     {1, 2, Side::child, Common::total}});
}

TEST_CASE("A weld inserted in a bar changes no other reaction", "[closed form][equivalents][quick]") {
  const Model whole = read("bar_whole");
  const Model welded = read("bar_welded");
  for (std::size_t which = 0; which < 2; ++which) {
    const auto solver = std::move(both_solvers(whole)[which]);
    INFO(solver->name());
    const double digits =
        agreement(short_run(*solver), short_run(*both_solvers(welded)[which]),
                  {{0, 0, Side::parent}, {0, 0, Side::child}, {1, 2, Side::parent}, {1, 2, Side::child}});
    tell("bar cut in two and welded", *solver, digits);
    CHECK(digits >= 10.5);
  }
}

}  // namespace concord::verification
