#include <catch2/catch.hpp>
#include <numbers>

#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/equilibrium/started_machine.h"

/// The car: what must hold of it whatever its numbers are.
namespace concord::verification {
namespace {

/// A model of data/models that starts where both solvers find its equilibrium.
Model settled(const std::string& name) {
  std::string note;
  const Model model = read_model(std::filesystem::path(CONCORD_DATA) / "models" / (name + ".toml"));
  return compare::as_it_starts(model, kMakers, note);
}

std::size_t joint_of(const Model& model, const std::string& name) {
  const auto found =
      std::find_if(model.joints.begin(), model.joints.end(), [&](const Joint& joint) { return joint.name == name; });
  REQUIRE(found != model.joints.end());
  return static_cast<std::size_t>(found - model.joints.begin());
}

const Wrench& element_on(const Model& model, const Evaluation& evaluation, const std::string& name) {
  const auto found = std::find_if(model.elements.begin(), model.elements.end(),
                                  [&](const ForceElement& element) { return element.name == name; });
  REQUIRE(found != model.elements.end());
  return evaluation.elements[static_cast<std::size_t>(found - model.elements.begin())].on_side(Side::child).in_global;
}

State at_rest(Solver& solver) {
  State rest = solver.assemble();
  for (BodyState& body : rest.bodies) {
    body.v.setZero();
    body.omega.setZero();
  }
  return rest;
}

TEST_CASE("The tires of the car at rest bear what statics says of its axles", "[car]") {
  const Model model = settled("car");
  for (const bool by_cartesian : {true, false}) {
    const auto solver = by_cartesian ? cartesian::make_solver(model) : relative::make_solver(model);
    const Evaluation evaluation = solver->evaluate(at_rest(*solver));
    const auto axle = [&](const std::string& end) {
      return element_on(model, evaluation, end + "_left_tire").force.z() +
             element_on(model, evaluation, end + "_right_tire").force.z();
    };
    // models/README.md: sprung mass by its lever, axle masses, and the trailing arms' centres ahead of their wheels.
    CHECK(axle("front") == Approx(7433.0).epsilon(0.005));
    CHECK(axle("rear") == Approx(4593.0).epsilon(0.005));
  }
}

TEST_CASE("The car has fifteen degrees of freedom", "[car]") {
  const Model model = settled("car");
  for (const auto& solver : {cartesian::make_solver(model), relative::make_solver(model)}) {
    CHECK(solver->rank(solver->assemble()).degrees_of_freedom == 15);
  }
}

TEST_CASE("Wherever the car's loops are cut, its reactions are the same", "[car]") {
  const Model model = settled("car");
  const auto usual = relative::make_solver(model);
  const State state = usual->assemble();
  const Evaluation expected = usual->evaluate(state);
  double largest = 0.0;
  for (const JointWrenches& joint : expected.joints) {
    largest = std::max(largest, joint.total_on(Side::child).in_C.force.norm());
  }
  // One choice for each of the four loops, another one in each row.
  const std::vector<std::vector<std::string>> choices{
      {"front_left_arm", "front_left_tie_rod", "front_right_strut_top", "front_right_tie_rod"},
      {"front_left_strut", "front_left_tie_rod", "front_right_ball", "front_right_tie_rod"},
      {"front_left_strut_top", "front_left_tie_rod", "front_right_arm", "front_right_strut"}};
  for (const auto& choice : choices) {
    Model other = model;
    for (const std::string& name : choice) other.joints[joint_of(model, name)].named_as_cut = true;
    const auto solver = relative::make_solver(other);
    CHECK(solver->cut_joints().size() == 4);
    const Evaluation found = solver->evaluate(state);
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      for (const Side side : {Side::parent, Side::child}) {
        const Vec6 difference =
            found.joints[k].reaction_on(side).in_C.vector() - expected.joints[k].reaction_on(side).in_C.vector();
        INFO(choice.front() << " cut: joint " << model.joints[k].name);
        CHECK(difference.norm() < 1e-10 * largest);
      }
    }
  }
}

TEST_CASE("Over a bump that both sides meet, left and right carry the same and nothing pushes the car sideways",
          "[car]") {
  const Model model = settled("car");
  RunOptions options;
  options.until = 6.2;
  options.rtol = 1e-9;
  options.samples = 310;
  for (const auto& solver : {cartesian::make_solver(model), relative::make_solver(model)}) {
    const Trajectory run = solver->integrate(options, [](double) {});
    double peak = 0.0;
    double sideways = 0.0;
    double apart = 0.0;
    for (const Sample& sample : run.samples) {
      double sum = 0.0;
      for (const char* tire : {"front_left_tire", "front_right_tire", "rear_left_tire", "rear_right_tire"}) {
        const Vec3 force = element_on(model, sample.evaluation, tire).force;
        sum += force.y();
        peak = std::max(peak, force.norm());
      }
      sideways = std::max(sideways, std::abs(sum));
      for (const char* name : {"arm", "ball", "strut_top", "strut", "tie_rod", "hub"}) {
        const auto size = [&](const std::string& side) {
          const std::size_t k = joint_of(model, "front_" + side + "_" + name);
          return sample.evaluation.joints[k].total_on(Side::child).in_C.force.norm();
        };
        apart = std::max(apart, std::abs(size("left") - size("right")));
      }
    }
    INFO(solver->name() << ": apart " << apart << " N, sideways " << sideways << " N, peak " << peak << " N");
    CHECK(apart < 1e-9 * peak);
    CHECK(sideways < 1e-9 * peak);
  }
}

/// The car without dampers and without what its tires do along the road.
Model undamped(Model model) {
  for (Joint& joint : model.joints) {
    for (JointSpring& spring : joint.springs) spring.law.damping = 0.0;
  }
  for (ForceElement& element : model.elements) {
    if (auto* line = std::get_if<LineSpring>(&element.what)) line->law.damping = 0.0;
    if (auto* tire = std::get_if<Tire>(&element.what))
      tire->damping = tire->slip_stiffness = tire->cornering_stiffness = 0.0;
  }
  return model;
}

/// Frequencies [Hz] of the bounce and pitch of a rigid body of the car's sprung mass on two rates [N/m], one for each
/// axle: roots of det(K - w^2 M) = 0.
std::array<double, 2> bounce_and_pitch(double front, double rear) {
  const double mass = 1094.5;
  const double inertia = 1342.0;
  const double ahead = 0.884;
  const double behind = 2.393 - ahead;
  const double k_pitch =
      front * ahead * ahead + rear * behind * behind - mass * 9.81 * 0.25;  // 0.25 m above the wheels
  const double k_mixed = rear * behind - front * ahead;
  const double half = 0.5 * ((front + rear) / mass + k_pitch / inertia);
  const double product = ((front + rear) * k_pitch - k_mixed * k_mixed) / (mass * inertia);
  const double root = std::sqrt(half * half - product);
  return {std::sqrt(half - root) / (2.0 * std::numbers::pi), std::sqrt(half + root) / (2.0 * std::numbers::pi)};
}

TEST_CASE("Bounce, pitch and wheel hop of the undamped car are those of its rates and effective masses by hand",
          "[car]") {
  const Model model = undamped(settled("car"));
  const double tire = 190e3;
  // By hand, models/README.md: the spring's rate at the wheel, and what the change of the travels' ratio adds.
  const double front = 21.9e3 + 3589.0 * 0.909 + 34.0;
  const double rear = 21.9e3 + 2538.0 * 0.212;
  const double twist = 2.0 * (79.3e9 * 5.12e-9 + 12.0 * 2.1e11 * 2.5e-7 * 0.03 * 0.03) / (0.4 * 0.4);
  const auto in_series = [&](double rate) { return 2.0 * rate * tire / (rate + tire); };
  const auto hop = [&](double rate, double mass) { return std::sqrt((rate + tire) / mass) / (2.0 * std::numbers::pi); };
  const std::array<double, 2> bounce = bounce_and_pitch(in_series(front), in_series(rear));
  for (const bool by_cartesian : {true, false}) {
    const auto solver = by_cartesian ? cartesian::make_solver(model) : relative::make_solver(model);
    std::vector<double> found;
    for (const auto& mode : compare::analyses::linearize(model, *solver, at_rest(*solver)).modes) {
      if (mode.oscillates() && !mode.is_free) found.push_back(mode.frequency());
    }
    std::sort(found.begin(), found.end());
    INFO(solver->name() << " finds " << Catch::Detail::stringify(found));
    REQUIRE(found.size() == 8);  // bounce, pitch, roll, four hops, rack
    CHECK(found[0] == Approx(bounce[0]).epsilon(0.03));
    CHECK(found[1] == Approx(bounce[1]).epsilon(0.03));
    CHECK(found[3] == Approx(hop(front, 29.8)).epsilon(0.03));
    CHECK(found[4] == Approx(hop(front, 29.8)).epsilon(0.03));
    CHECK(found[5] == Approx(hop(rear, 25.6)).epsilon(0.03));
    CHECK(found[6] == Approx(hop(rear + twist, 25.6)).epsilon(0.03));
  }
}

/// The part of what the hinges of the rear arms carry that symmetry of left and right forbids, and the arms' turn
/// against each other.
struct Opposed {
  double force = 0.0;   // along y of the hinges' frames, which points down: half the difference
  double torque = 0.0;  // about x, forward, where the mirror turns the sign: half the sum
  double turn = 0.0;
};

std::vector<Opposed> opposed_over_bump(const std::string& name) {
  const Model model = settled(name);
  RunOptions options;
  options.until = 6.4;
  options.rtol = 1e-8;
  options.samples = 640;
  const std::size_t left = joint_of(model, "rear_left_arm");
  const std::size_t right = joint_of(model, "rear_right_arm");
  std::vector<Opposed> opposed;
  for (const Sample& sample : relative::make_solver(model)->integrate(options, [](double) {}).samples) {
    const auto reaction = [&](std::size_t k) -> const Wrench& {
      return sample.evaluation.joints[k].reaction_on(Side::child).in_C;
    };
    opposed.push_back({0.5 * (reaction(left).force.y() - reaction(right).force.y()),
                       0.5 * (reaction(left).torque.x() + reaction(right).torque.x()),
                       sample.state.q[left](0) - sample.state.q[right](0)});
  }
  return opposed;
}

TEST_CASE(
    "What a flexible beam adds to the rear arms' hinges, beside the twist that a spring would give, is the shear "
    "12 E I d turn / L^3 of its opposite bending, and that shear's lever L / 2",
    "[car]") {
  const std::vector<Opposed> spring = opposed_over_bump("car_left_bump");
  const std::vector<Opposed> beam = opposed_over_bump("car_flexible_beam");
  const double shear_per_turn = 12.0 * 2.1e11 * 2.5e-7 * 0.03;  // N/rad: the beam of 1 m lies 0.03 m behind the hinges
  double largest = 0.0;
  double force_error = 0.0;
  double torque_error = 0.0;
  for (std::size_t k = 0; k < spring.size(); ++k) {
    const double shear = shear_per_turn * beam[k].turn;
    largest = std::max(largest, std::abs(shear));
    force_error = std::max(force_error, std::abs(beam[k].force - spring[k].force + shear));
    torque_error = std::max(torque_error, std::abs(beam[k].torque - spring[k].torque + 0.5 * shear));
  }
  CHECK(largest > 600.0);  // the bump turns one arm by 2 degrees against the other
  CHECK(force_error < 0.03 * largest);
  CHECK(torque_error < 0.5 * 0.01 * largest);
}

}  // namespace
}  // namespace concord::verification
