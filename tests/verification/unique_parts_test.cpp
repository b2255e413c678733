#include <catch2/catch.hpp>
#include <set>

#include "closed_forms.h"
#include "common/error.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"
#include "compare/audit/cures.h"
#include "compare/report/report_json.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"

/// What of reactions is unique though components of them are not, in words of an engineer: loads of bearings, planar
/// machines, and which joint to change.
namespace concord::verification {
namespace {

/// An arm that swings on an oblique axle in two balls, as that of a suspension does, moved by a crank through a rod.
/// The axes of the balls are those of the ground.
constexpr const char* kArm = R"(format = 1
gravity = [1.3, -0.7, -9.6]
[[body]]
name = "arm"
mass = 2.3
center_of_mass = [0.11, 0.21, -0.04]
inertia = [0.02, 0.015, 0.03, 0.001, -0.002, 0.003]
[[body]]
name = "crank"
mass = 0.4
inertia = [0.001, 0.001, 0.001]
[[joint]]
name = "front"
type = "spherical"
both = { point = [0.13, -0.02, 0.05] }
parent = "ground"
child = "arm"
[[joint]]
name = "rear"
type = "spherical"
both = { point = [-0.17, 0.38, -0.15] }
parent = "ground"
child = "arm"
[[joint]]
name = "shaft"
type = "revolute"
parent = { body = "ground", point = [0.2, 0.35, -0.3], axis = [1, 2, -1], angle = "20 deg" }
child = "crank"
drive.turn_z = { law = "harmonic", amplitude = 0.4, frequency = 9, offset = 0.2 }
[[joint]]
name = "rod"
type = "distance"
length = 0.41
parent = { body = "crank", point = [0.06, 0, 0] }
child = { body = "arm", point = [0.2, 0.3, 0.1] }
[[load]]
name = "push"
body = "arm"
point = [0.2, 0.1, 0.1]
force = [12, 35, -21]
torque = [0.7, -0.4, 1.1]
[run]
until = 0.4
samples = 200
)";

const std::array<Vec3, 2> kBearings{Vec3(0.13, -0.02, 0.05), Vec3(-0.17, 0.38, -0.15)};

/// What one of the bearings carries across the axle: from the moments about the other one, of inertia, weight, load and
/// rod alone. All in global axes.
Vec3 across_by_moments(const Model& model, const Sample& sample, int bearing) {
  const Vec3& other = kBearings[static_cast<std::size_t>(1 - bearing)];
  const Body& arm = model.bodies[1];
  const BodyState& at = sample.state.bodies[1];
  const BodyAcceleration& acceleration = sample.evaluation.bodies[1];
  const Mat3 A = rotation_of(at.p);
  const auto arm_to = [&](const Vec3& point) { return Vec3(at.r + A * point - other); };
  const Vec3 c = A * arm.center_of_mass_L;
  const Vec3 of_centre = acceleration.vdot + acceleration.omegadot.cross(c) + at.omega.cross(at.omega.cross(c));
  const Mat3 I = A * arm.inertia_L * A.transpose();
  const Vec3 inertia = I * acceleration.omegadot + at.omega.cross(I * at.omega);
  const Vec3& by_rod = sample.evaluation.joints[3].total_on(Side::child).in_global.force;
  const Vec3 moment = arm.mass * arm_to(arm.center_of_mass_L).cross(of_centre - model.gravity) + inertia -
                      arm_to({0.2, 0.1, 0.1}).cross(Vec3(12, 35, -21)) - Vec3(0.7, -0.4, 1.1) -
                      arm_to({0.2, 0.3, 0.1}).cross(by_rod);
  const Vec3 d = kBearings[static_cast<std::size_t>(bearing)] - other;
  return moment.cross(d) / d.squaredNorm();
}

const compare::PartlyUnique& part_of(const compare::Verdict& verdict, int joint, Side side) {
  const auto& all = verdict.partly_unique;
  const auto found = std::find_if(all.begin(), all.end(), [&](const compare::PartlyUnique& one) {
    return one.of.owner == joint && one.of.side == side;
  });
  REQUIRE(found != all.end());
  return *found;
}

int count_of(const std::string& text, const std::string& words) {
  int count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++count;
  return count;
}

TEST_CASE("The radial loads of two bearings of one axle are judged and told though their axial loads are not unique") {
  const Model model = parse(kArm);
  const auto solvers = both_solvers(model);
  const compare::Verdict verdict = compare::verify(model, *solvers[0], *solvers[1], {});
  const std::string table = compare::format_verdict(model, verdict, false);
  INFO(table);
  CHECK(verdict.outcome == compare::Outcome::agree);
  REQUIRE(verdict.partly_unique.size() == 4);
  const Vec3 axle = (kBearings[1] - kBearings[0]).normalized();
  REQUIRE(verdict.trajectories[0]);
  for (int bearing = 0; bearing < 2; ++bearing) {
    double peak = 0.0;
    for (const Sample& sample : verdict.trajectories[0]->samples) {
      peak = std::max(peak, across_by_moments(model, sample, bearing).norm());
    }
    for (const Side side : kSides) {
      const compare::PartlyUnique& part = part_of(verdict, bearing, side);
      CHECK(part.digits >= 12.0);
      CHECK(part.samples == verdict.same_state.samples);
      CHECK(part.is_fixed);
      CHECK(part.peak == Approx(peak).epsilon(1e-8));
      const BodyState& start = verdict.trajectories[0]->samples[0].state.bodies[1];
      const Mat3 A = side == Side::child ? rotation_of(start.p) : Mat3(Mat3::Identity());
      CHECK((A * part.left_out).col(0).cross(axle).norm() < 1e-9);
    }
  }
  CHECK_THAT(table, Catch::Contains("(part) |") && Catch::Contains("|   F 1") &&
                        Catch::Contains("unique: joint front on ground, F but for its part along (-0.557086, 0.742781, "
                                        "-0.371391) of ground: "));
  CHECK(count_of(table, "not unique, not judged: joint ") == 4);
  CHECK_FALSE(verdict.planar);
  CHECK_THAT(compare::format_json(model, verdict), Catch::Contains("\"partly_unique\""));
}

TEST_CASE("In a pose the radial loads of two bearings are told by each analysis") {
  const Model model = parse(kArm);
  const compare::analyses::AnalysisVerdict rest = compare::analyses::judge_statics(model, kMakers);
  INFO(compare::analyses::format_analysis(model, rest, false));
  CHECK(rest.wrenches.outcome == compare::Outcome::agree);
  REQUIRE(rest.wrenches.trajectories[0]);
  const Sample& found = rest.wrenches.trajectories[0]->samples[0];
  for (int bearing = 0; bearing < 2; ++bearing) {
    const double exact = across_by_moments(model, found, bearing).norm();
    CHECK(part_of(rest.wrenches, bearing, Side::child).peak == Approx(exact).epsilon(1e-9));
    CHECK(part_of(rest.wrenches, bearing, Side::parent).peak == Approx(exact).epsilon(1e-9));
  }
}

/// Four levers in a plane that stands obliquely, with the joints of these types.
Model levers(const std::array<std::string, 4>& types) {
  const auto start = [&](int joint, const char* degrees) {
    const bool has_turn = types[static_cast<std::size_t>(joint)] != "spherical";
    return has_turn ? fmt::format("start.turn_z = {{ {} }}", degrees) : std::string();
  };
  const Model model = parse(fmt::format(
      R"(format = 1
gravity = [2.1, -9.4, -1.4]
[[body]]
name = "left"
mass = 1
center_of_mass = [0.01, 0.15, 0.02]
inertia = [0.01, 0.001, 0.01]
[[body]]
name = "bar"
mass = 1.5
center_of_mass = [0.25, 0.01, -0.03]
inertia = [0.001, 0.03, 0.03]
[[body]]
name = "right"
mass = 1.2
center_of_mass = [0, 0.15, 0.01]
inertia = [0.01, 0.001, 0.01]
[[joint]]
name = "p1"
type = "{}"
parent = "ground"
child = "left"
{}
[[joint]]
name = "p2"
type = "{}"
parent = {{ body = "left", point = [0, 0.3, 0] }}
child = "bar"
{}
[[joint]]
name = "p3"
type = "{}"
parent = {{ body = "bar", point = [0.5, 0, 0] }}
child = {{ body = "right", point = [0, 0.35, 0] }}
[[joint]]
name = "p4"
type = "{}"
parent = {{ body = "ground", point = [0.45, 0, 0] }}
child = "right"
{}
[run]
until = 0.2
samples = 60
)",
      types[0], start(0, "keep = \"10 deg\", keep_speed = 1"), types[1], start(1, "guess = \"-5 deg\""), types[2],
      types[3], start(3, types[0] == "spherical" ? "keep = \"0.8 deg\", keep_speed = 1" : "guess = \"0 deg\"")));
  return turn_world(model, rotation_about(Vec3(2, 1, -2) / 3.0, 0.8));
}

const std::array<std::string, 4> kHinges{"revolute", "revolute", "revolute", "revolute"};

TEST_CASE("A planar machine closed with hinges says in one line what is not unique, and lists it by joint if asked") {
  const Model model = levers(kHinges);
  const auto solvers = both_solvers(model);
  const compare::Verdict verdict = compare::verify(model, *solvers[0], *solvers[1], {});
  const std::string table = compare::format_verdict(model, verdict, false);
  INFO(table);
  CHECK(verdict.outcome == compare::Outcome::agree);
  REQUIRE(verdict.planar);
  CHECK(verdict.planar->joints == std::vector<int>{0, 1, 2, 3});
  const Vec3 normal = rotation_about(Vec3(2, 1, -2) / 3.0, 0.8).col(2);
  CHECK(verdict.planar->normal.cross(normal).norm() < 1e-9);
  CHECK(verdict.partly_unique.empty());  // the components show it all
  CHECK(count_of(table, "not unique, not judged:") == 1);
  CHECK_THAT(table, Catch::Contains(": forces along it and torques about axes in the plane in joints p1, p2, p3, p4 "
                                    "(--all lists them)\n"));
  CHECK_THAT(table,
             Catch::Contains("all reactions would be unique if joint p1 were cylindrical and joint p2 spherical\n") &&
                 Catch::Contains("and so with 9 more such changes of two joints (12 tried)\n"));
  const std::string all = compare::format_verdict(model, verdict, true);
  CHECK(count_of(all, "not unique, not judged: joint p") == 8);
  CHECK_THAT(all, Catch::Contains("not unique, not judged: joint p3 on right: F_z T_x T_y\n"));
  CHECK(count_of(compare::format_json(model, verdict), "\"unique\": false") == 24);
}

/// As both solvers count them at the start; they refuse one that is kept in other than its degrees of freedom.
bool has_no_redundant_constraint(const Model& model) {
  try {
    for (const auto& solver : both_solvers(model)) {
      const RankReport rank = solver->rank(solver->assemble());
      if (rank.undecided || rank.rank != rank.constraints || rank.degrees_of_freedom != 1) return false;
    }
  } catch (const InputError&) {
    return false;
  }
  return true;
}

TEST_CASE("The changes of two joints that are said to make all reactions of a four-bar unique do so, and no others") {
  const Model model = levers(kHinges);
  const auto solver = cartesian::make_solver(model);
  const compare::Cures cures = compare::find_cures(model, solver->assemble());
  CHECK(cures.redundant == 3);
  CHECK(cures.is_complete);
  std::set<std::array<std::string, 4>> told;
  for (const auto& changes : cures.found) {
    REQUIRE(changes.size() == 2);
    std::array<std::string, 4> types = kHinges;
    for (const compare::JointChange& change : changes) {
      types[static_cast<std::size_t>(change.joint)] = change.to->name;
    }
    told.insert(types);
  }
  CHECK(told.size() == 12);
  for (int one = 0; one < 4; ++one) {
    for (int other = 0; other < 4; ++other) {
      for (const char* type : {"cylindrical", "spherical"}) {
        std::array<std::string, 4> types = kHinges;
        types[static_cast<std::size_t>(one)] = "spherical";
        types[static_cast<std::size_t>(other)] = type;
        INFO(types[0] << " " << types[1] << " " << types[2] << " " << types[3]);
        CHECK(has_no_redundant_constraint(levers(types)) == (told.count(types) == 1));
      }
    }
  }
  CHECK(compare::describe(model, cures.found.at(0)) == "joint p1 were cylindrical and joint p2 spherical");
}

}  // namespace
}  // namespace concord::verification
