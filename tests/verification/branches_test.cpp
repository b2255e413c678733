#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "closed_forms.h"
#include "common/error.h"
#include "compare/equilibrium/started_machine.h"
#include "compare/states/branch.h"
#include "judged_machines.h"

/// Machines whose guesses leave open how their loops close.
namespace concord::verification {
namespace {

/// A spherical four-bar, links of 40, 80, 70 and 75 degrees, all axes through one point.
std::string spherical_four_bar(const std::string& coupler, const std::string& rocker, const std::string& last) {
  const auto guess = [](const std::string& value) {
    return value.empty() ? "" : fmt::format("start.turn_z = {{ guess = \"{} deg\" }}\n", value);
  };
  return fmt::format(R"toml(format = 1
gravity = [0.3, -1, -9.7]
[[body]]
name = "crank"
mass = 1
center_of_mass = [0.1, 0, 0.2]
inertia = [0.01, 0.012, 0.008]
[[body]]
name = "coupler"
mass = 1.5
center_of_mass = [0, 0.1, 0.2]
inertia = [0.02, 0.015, 0.01]
[[body]]
name = "rocker"
mass = 1.2
center_of_mass = [0.05, 0.02, 0.2]
inertia = [0.01, 0.013, 0.011]
[[joint]]
name = "J1"
type = "revolute"
parent = "ground"
child = "crank"
start.turn_z = {{ keep = "60 deg", keep_speed = 20 }}
[[joint]]
name = "J2"
type = "revolute"
parent = {{ body = "crank", axis = [1, 0, 0], angle = "40 deg" }}
child = "coupler"
{}[[joint]]
name = "J3"
type = "revolute"
parent = {{ body = "coupler", axis = [1, 0, 0], angle = "80 deg" }}
child = "rocker"
{}[[joint]]
name = "J4"
type = "revolute"
parent = {{ body = "rocker", axis = [1, 0, 0], angle = "70 deg" }}
child = {{ body = "ground", axis = [1, 0, 0], angle = "-75 deg" }}
{}[run]
until = 0.5
)toml",
                     guess(coupler), guess(rocker), guess(last));
}

TEST_CASE("Whatever the guesses are, both solvers start on one branch, the one next to them if one is", "[closure]") {
  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  int noted = 0;
  int refused = 0;
  for (const int coupler : {-150, -60, 30, 150}) {
    for (const int rocker : {-120, -60, 60, 120}) {
      for (const int last : {-100, 60, 170}) {
        INFO(coupler << ", " << rocker << ", " << last);
        Model model =
            parse(spherical_four_bar(fmt::format("{}", coupler), fmt::format("{}", rocker), fmt::format("{}", last)));
        std::string note;
        compare::Solvers solvers;
        try {
          solvers = compare::make_solvers_on_one_branch(model, makers, note);
        } catch (const InputError&) {
          ++refused;  // for both solvers the joints close turned round
          continue;
        }
        const State one = solvers[0]->assemble();
        const State other = solvers[1]->assemble();
        noted += note.empty() ? 0 : 1;
        for (std::size_t k = 0; k < 4; ++k) CHECK((one.q[k] - other.q[k]).norm() < 1e-12);
        CHECK(one.q[0](0) == Approx(std::numbers::pi / 3.0).epsilon(1e-14));
      }
    }
  }
  CHECK(noted > 0);     // else this test tries nothing
  CHECK(refused < 16);  // of 48
}

/// Three bars of 4 m on a frame of 2 m. The guesses of the last pins lead round a whole turn. `spring`: a line of the
/// last joint.
Model three_bars(const std::string& spring) {
  const auto bar = [](const char* name) {
    return fmt::format("[[body]]\nname = \"{}\"\nmass = 20\ncenter_of_mass = [2, 0, 0.1]\ninertia = [0.1, 29, 29]\n",
                       name);
  };
  const Model model = parse(fmt::format(R"toml(format = 1
gravity = [0, 0, -9.81]
[parameters]
qa = "atan(sqrt(15))"
{}{}{}[[joint]]
name = "WA"
type = "revolute"
both = {{ z = [0, 1, 0], x = [1, 0, 0] }}
parent = "ground"
child = "A"
start.turn_z = {{ keep = "qa", keep_speed = 0.4 }}
[[joint]]
name = "AB"
type = "revolute"
both = {{ z = [0, 1, 0], x = [1, 0, 0] }}
parent = {{ body = "A", point = [4, 0, 0] }}
child = "B"
start.turn_z = {{ guess = "pi - qa" }}
[[joint]]
name = "WC"
type = "revolute"
both = {{ z = [0, 1, 0], x = [1, 0, 0] }}
parent = {{ body = "ground", point = [-2, 0, 0] }}
child = "C"
start.turn_z = {{ guess = "pi - qa" }}
[[joint]]
name = "BC"
type = "revolute"
both = {{ point = [4, 0, 0], z = [0, 1, 0], x = [1, 0, 0] }}
parent = "B"
child = "C"
start.turn_z = {{ guess = "pi - qa" }}
{}
[run]
until = 0.2
)toml",
                                        bar("A"), bar("B"), bar("C"), spring));
  return turn_world(model, rotation_about(Vec3(0.6, -0.3, 0.7).normalized(), 0.8));
}

TEST_CASE("Starts that are whole turns apart are one, unless something reads the angle", "[closure]") {
  const auto note_of = [](const std::string& spring) {
    Model model = three_bars(spring);
    std::string note;
    const compare::Solvers solvers = compare::make_solvers_on_one_branch(model, kMakers, note);
    CHECK(std::abs(solvers[0]->assemble().q[3](0) - solvers[1]->assemble().q[3](0)) < 1e-9);
    return note;
  };
  CHECK(note_of("").empty());
  CHECK(note_of("spring.turn_z = { damping = 3, preload = 2 }").empty());
  CHECK(note_of("spring.turn_z = { stiffness = 3 }").find("different branches (turn_z of BC 284") != std::string::npos);
  const Model model = three_bars("");
  expect_to_agree(model, in_short(model, 1.0));
}

TEST_CASE("The other pose in which a linkage closes is found, with the angles of the other triangle", "[closure]") {
  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  const Model model = three_bars("");
  const compare::StartedMachine machine(model, makers);
  const auto report = compare::start_of(model, machine, makers, compare::SeekPoses::of_all);
  REQUIRE(report);
  REQUIRE(report->others.values.size() == 1);
  const std::vector<VecX>& found = report->others.values.front();  // WA, AB, WC, BC
  const double qa = std::atan(std::sqrt(15.0));
  CHECK(std::abs(found[0](0) - qa) < 1e-9);
  CHECK(std::abs(found[1](0) - 2.0 * (std::numbers::pi - qa)) < 1e-9);
  CHECK(std::abs(found[2](0)) < 1e-9);
  CHECK(report->others.found_by == "relative");
  CHECK(report->others.accepted_by == "cartesian");
}

TEST_CASE("A linkage without guesses that one solver cannot close starts from what the other one finds", "[closure]") {
  Model model = parse(spherical_four_bar("", "", ""));
  std::string note;
  const compare::SolverMakers makers{cartesian::make_solver, relative::make_solver};
  const compare::Solvers solvers = compare::make_solvers_on_one_branch(model, makers, note);
  CHECK((solvers[0]->assemble().q[2] - solvers[1]->assemble().q[2]).norm() < 1e-12);
}

TEST_CASE("Where compare starts a machine, info and a run of one solver start it too", "[closure]") {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / fmt::format("branches_{}.toml", getpid());
  std::ofstream(file) << spherical_four_bar("-150", "60", "-100");  // cartesian alone finds no start
  for (const std::string command : {"info", "run --solver cartesian", "run --solver relative", "compare"}) {
    INFO(command);
    const std::string line = fmt::format("'" CONCORD_PROGRAM "' {} '{}' > /dev/null 2>&1", command, file.string());
    CHECK(std::system(line.c_str()) == 0);
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace concord::verification
