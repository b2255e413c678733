#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "closed_forms.h"
#include "compare/resolution/jumps.h"
#include "judged_machines.h"

/// Events that fall on output times, where a force jumps: round-off decides on which side of the jump a sample lies.
namespace concord::verification {
namespace {

/// A wheel that a carriage leads over a half-sine bump at a constant speed, turning on its hub or fixed to the
/// carriage.
Model wheel_over_bump(double from, double speed, double start, double length, bool turns) {
  const std::string hub = fmt::format(R"([[body]]
name = "carriage"
mass = 3
inertia = [0.1, 0.2, 0.1]
[[joint]]
name = "hub"
type = "revolute"
parent = {{ body = "carriage", z = [0, 1, 0], x = [1, 0, 0] }}
child = {{ body = "wheel", z = [0, 1, 0], x = [1, 0, 0] }}
start.turn_z = {{ keep = 0, keep_speed = {} }}
)",
                                      speed / 0.28);
  return parse(fmt::format(R"(format = 1
gravity = [0, 0, -9.81]
[[road]]
name = "r"
profile = "half_sine"
start = {}
length = {}
height = 0.03
[[body]]
name = "wheel"
mass = 15
inertia = [0.5, 0.9, 0.5]
[[joint]]
name = "rail"
type = "translational"
parent = {{ body = "ground", point = [0, 0, 0.29], x = [0, 1, 0], z = [1, 0, 0] }}
child = {{ body = "{}", x = [0, 1, 0], z = [1, 0, 0] }}
drive.slide_z = {{ law = "polynomial", coefficients = [{}, {}] }}
[[tire]]
name = "t"
body = "wheel"
road = "r"
radius = 0.3
stiffness = 2e5
slip_stiffness = 4e4
cornering_stiffness = 4e4
friction = 0.9
[run]
until = 0.4
samples = 200
)",
                           start, length, turns ? "carriage" : "wheel", from, speed) +
               (turns ? hub : ""));
}

TEST_CASE("A wheel meets and leaves a bump at output times: no jump is a difference", "[verdict]") {
  struct Course {
    double from, speed;
    int meets, leaves;  // samples of 2 ms
  };
  for (const Course course : {Course{0.3, 7.0, 50, 150}, Course{0.7, 4.4, 130, 170}, Course{0.1, 3.0, 20, 180},
                              Course{-0.2, 2.9, 75, 170}, Course{1.1, 11.0, 100, 150}}) {
    for (const bool turns : {false, true}) {
      const double start = course.from + course.speed * 0.002 * course.meets;
      const double length = course.speed * 0.002 * (course.leaves - course.meets);
      INFO("from " << course.from << " at " << course.speed << (turns ? ", turning" : ", fixed"));
      expect_to_agree(wheel_over_bump(course.from, course.speed, start, length, turns), {});
    }
  }
}

/// A wheel led to the right that meets a bump at x = 0.5, at t = 0.1 s.
class WheelAtAnEdge {
 public:
  /// What a solver says at t, before which the jump is if t is larger than 0.1 s.
  [[nodiscard]] Sample at(double t) const {
    State state = cartesian_->assemble();
    state.t = t;
    state.bodies[1].r(0) = 5.0 * t;
    state.q[0](0) = 5.0 * t;
    const State closed = *cartesian_->close(state);
    return {closed, cartesian_->evaluate(closed), 0.0};
  }

  /// One sample, in which the solvers gave what stands at two times.
  [[nodiscard]] compare::Series series(const Sample& sample, const Sample& one, const Sample& other) const {
    compare::Series both{{sample.state.t}, {}, std::vector<double>(model_.bodies.size(), 0.0)};
    both.values = {layout_.observe(one.state, one.evaluation), layout_.observe(other.state, other.evaluation)};
    return both;
  }

  std::vector<double> found(const Sample& sample, const compare::Series& both) {
    resolution_ = MatX::Constant(both.values[0].rows(), 1, 1e-12);
    return compare::widen_at_jumps(
        layout_, {cartesian_.get(), relative_.get()}, both, compare::measure(layout_, both),
        [&](std::size_t) { return sample; }, 7.0, resolution_);
  }

  [[nodiscard]] const MatX& resolution() const { return resolution_; }

 private:
  Model model_ = wheel_over_bump(0.0, 5.0, 0.5, 0.4, false);
  compare::QuantityLayout layout_{model_};
  std::unique_ptr<Solver> cartesian_ = cartesian::make_solver(model_);
  std::unique_ptr<Solver> relative_ = relative::make_solver(model_);
  MatX resolution_;
};

TEST_CASE("Both sides of a jump in one sample are no difference", "[verdict][quick]") {
  WheelAtAnEdge wheel;
  const Sample sample = wheel.at(0.1);
  const compare::Series both = wheel.series(sample, wheel.at(0.1 - 1e-12), wheel.at(0.1 + 1e-12));
  CHECK(wheel.found(sample, both) == std::vector<double>{0.1});
  const MatX difference = (both.values[0] - both.values[1]).cwiseAbs();
  CHECK(difference.maxCoeff() > 100.0);
  CHECK(wheel.resolution().maxCoeff() == difference.maxCoeff());
}

TEST_CASE("What is on neither side of a jump is a difference", "[verdict][quick]") {
  WheelAtAnEdge wheel;
  const Sample sample = wheel.at(0.1);
  compare::Series both = wheel.series(sample, wheel.at(0.1 - 1e-12), wheel.at(0.1 + 1e-12));
  both.values[1] *= 1.001;
  CHECK(wheel.found(sample, both).empty());
  CHECK(wheel.resolution().maxCoeff() == 1e-12);
}

TEST_CASE("A jump elsewhere explains nothing", "[verdict][quick]") {
  WheelAtAnEdge wheel;
  const Sample sample = wheel.at(0.101);
  CHECK(wheel.found(sample, wheel.series(sample, wheel.at(0.1 - 1e-12), sample)).empty());
}

TEST_CASE("Where no force jumps, what lies a little to both sides of it is a difference", "[verdict][quick]") {
  WheelAtAnEdge wheel;
  const Sample sample = wheel.at(0.11);
  compare::Series both = wheel.series(sample, sample, sample);
  both.values[0] *= 1.0 - 0.8e-7;  // seven digits are needed
  both.values[1] *= 1.0 + 0.8e-7;
  CHECK(wheel.found(sample, both).empty());
}

}  // namespace
}  // namespace concord::verification
