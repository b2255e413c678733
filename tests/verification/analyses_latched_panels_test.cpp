#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <regex>
#include <string>

#include "analysis_numbers.h"
#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"
#include "judged_machines.h"

/// Panels in a row that springs unfold until latches stop them, without gravity: soft up to a stiff stop, which a step
/// of a search leaps across.
namespace concord::verification {
namespace {

using compare::Outcome;
using compare::analyses::AnalysisVerdict;
using compare::analyses::format_analysis;
using compare::analyses::judge_statics;

struct Hinge {
  double latch;      // where its stop begins [rad]
  double stiffness;  // of its spring [N m/rad]
  double free;       // where that is relaxed [rad]
};

struct Stop {
  double stiffness;  // N m/rad
  double width;      // rad, over which it grows
};
constexpr Stop kSoft{350.0, 0.004};
constexpr Stop kStiff{3e4, 0.02};

/// The torque of a stop at the depth p: with z = p / w, c w (z^3 - z^4 / 2) up to z = 1, and c (p - w / 2) beyond.
double torque_at(const Stop& stop, double p) {
  const double z = p / stop.width;
  return stop.stiffness * (z < 1.0 ? stop.width * (z * z * z - 0.5 * z * z * z * z) : p - 0.5 * stop.width);
}

/// The depth at which the stop meets a torque that falls by `stiffness` with the depth.
double depth_under(const Stop& stop, double torque, double stiffness, double deepest) {
  double shallow = 0.0;
  double deep = deepest;
  for (int k = 0; k < 60; ++k) {
    const double p = 0.5 * (shallow + deep);
    (torque_at(stop, p) > torque - stiffness * p ? deep : shallow) = p;
  }
  return shallow;
}

double rest_of(const Hinge& hinge) {
  const double sense = hinge.free > hinge.latch ? 1.0 : -1.0;
  const double way = std::abs(hinge.free - hinge.latch);
  return hinge.latch + sense * depth_under(kSoft, hinge.stiffness * way, hinge.stiffness, way);
}

std::string panels(const std::array<Hinge, 3>& hinges, const std::string& base) {
  std::string text = "format = 1\ngravity = [0, 0, 0]\n" + base;
  for (std::size_t k = 0; k < hinges.size(); ++k) {
    const Hinge& hinge = hinges[k];
    const std::string parent = k == 0 ? "bus" : fmt::format("panel{}", k);
    text +=
        fmt::format(R"toml(
[[body]]
name = "panel{0}"
mass = {1}
center_of_mass = [0.31, -0.02, 0.04]
inertia = [0.4, 0.55, 0.9, 0.03, -0.02, 0.05]
[[joint]]
name = "hinge{0}"
type = "revolute"
parent = {{ body = "{2}", point = [{3}, 0.05, -0.02], axis = [1, 0.4, {4}], angle = {5} }}
child = {{ body = "panel{0}", point = [-0.03, 0.02, 0.01], axis = [0.3, 1, -0.5], angle = 0.6 }}
start.turn_z = {{ keep = 0, keep_speed = 0 }}
spring.turn_z = {{ stiffness = {6}, free = {7}, damping = 0.2, {8}_stop = {{ at = {9}, stiffness = {10}, width = {11} }} }}
)toml",
                    k + 1, 6.0 + static_cast<double>(k), parent, k == 0 ? 0.7 : 0.64,
                    0.2 - 0.3 * static_cast<double>(k), 0.5 + 0.4 * static_cast<double>(k), hinge.stiffness, hinge.free,
                    hinge.free > hinge.latch ? "upper" : "lower", hinge.latch, kSoft.stiffness, kSoft.width);
  }
  return text;
}

const std::string kBus = R"toml(
[[body]]
name = "bus"
mass = 210
center_of_mass = [0.05, -0.07, 0.01]
inertia = [71, 66, 79, -3, 2, 4]
[[joint]]
name = "stand"
type = "{}"
parent = {{ body = "ground", point = [0.2, -0.1, 0.3], axis = [1, 1, 2], angle = 0.8 }}
child = {{ body = "bus", point = [0.1, 0.05, -0.2], axis = [2, -1, 1], angle = 0.3 }}
{})toml";

const std::string kFloats =
    "start.slide_x = { keep = 0, keep_speed = 0 }\nstart.slide_y = { keep = 0, keep_speed = 0 }\n"
    "start.slide_z = { keep = 0, keep_speed = 0 }\nstart.ball = { keep = {}, keep_speed = [0, 0, 0] }\n";

TEST_CASE("Panels unfold to where their latches hold the springs, on the ground and on a satellite that floats",
          "[analyses]") {
  const std::array<Hinge, 3> hinges{Hinge{1.5, 0.45, 1.9}, Hinge{-3.0, 0.3, -3.7}, Hinge{2.9, 0.5, 3.6}};
  const bool floats = GENERATE(false, true);
  const Model model =
      parse(panels(hinges, fmt::format(fmt::runtime(kBus), floats ? "free" : "weld", floats ? kFloats : "")));
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(value_of(rest, "directions without stiffness") == (floats ? 6.0 : 0.0));
  for (std::size_t k = 0; k < hinges.size(); ++k) {
    CHECK_THAT(value_of(rest, fmt::format("turn_z of hinge{}", k + 1)), Catch::WithinAbs(rest_of(hinges[k]), 1e-9));
  }
}

/// A hinge that a motor of constant torque unfolds.
struct DrivenHinge {
  std::string parent;
  double torque;  // N m
  double start;   // rad
};

/// Rows of panels on both sides of a bus. `turn`: how the whole is turned [rad].
std::string satellite(const std::array<DrivenHinge, 5>& hinges, double turn) {
  std::string text = "format = 1\ngravity = [0, 0, 0]\n";
  text += fmt::format(fmt::runtime(kBus), "free", kFloats);
  text = std::regex_replace(text, std::regex("start.ball = \\{ keep = \\{\\}"),
                            fmt::format("start.ball = {{ keep = {{ axis = [2, -1, 3], angle = {} }}", turn));
  for (std::size_t k = 0; k < hinges.size(); ++k) {
    const DrivenHinge& hinge = hinges[k];
    const bool is_on_bus = hinge.parent == "bus";
    text += fmt::format(R"toml(
[[body]]
name = "panel{0}"
mass = {1}
center_of_mass = [0.31, -0.02, 0.04]
inertia = [0.04, 0.25, 0.28, 0.01, -0.01, 0.005]
[[joint]]
name = "hinge{0}"
type = "revolute"
parent = {{ body = "{2}", point = [{3}, 0.05, -0.02], axis = [0.1, 1, {4}], angle = {5} }}
child = {{ body = "panel{0}", point = [-0.03, 0.02, 0.01], axis = [0.05, 1, -0.1], angle = 0 }}
start.turn_z = {{ keep = {6}, keep_speed = 0 }}
spring.turn_z = {{ preload = {7}, damping = 0.2, upper_stop = {{ at = 0.3, stiffness = {8}, width = {9} }} }}
)toml",
                        k + 1, 2.0 + 0.3 * static_cast<double>(k), hinge.parent, is_on_bus ? 0.7 : 0.64,
                        0.1 * static_cast<double>(k), is_on_bus && k > 0 ? 3.2 : 0.1, hinge.start, -hinge.torque,
                        kStiff.stiffness, kStiff.width);
  }
  return text;
}

TEST_CASE("A satellite that floats comes to rest where its latches hold its motors, wherever it turns on the way",
          "[analyses]") {
  const std::array<DrivenHinge, 5> hinges{DrivenHinge{"bus", 0.41, -0.75}, DrivenHinge{"panel1", 0.72, -0.04},
                                          DrivenHinge{"bus", 0.92, -0.37}, DrivenHinge{"panel3", 0.76, -0.7},
                                          DrivenHinge{"panel4", 0.55, -0.2}};
  const double turn = GENERATE(0.0, 2.2);
  const Model model = parse(satellite(hinges, turn));
  const AnalysisVerdict rest = judge_statics(model, kMakers);
  INFO(format_analysis(model, rest, true));
  CHECK(rest.wrenches.outcome == Outcome::agree);
  CHECK(value_of(rest, "directions without stiffness") == 6.0);
  for (std::size_t k = 0; k < hinges.size(); ++k) {
    const double p = depth_under(kStiff, hinges[k].torque, 0.0, 1.0);
    CHECK_THAT(value_of(rest, fmt::format("turn_z of hinge{}", k + 1)), Catch::WithinAbs(0.3 + p, 1e-9));
  }
  for (const char* slide : {"slide_x", "slide_y", "slide_z"}) {
    CHECK_THAT(value_of(rest, std::string(slide) + " of stand"), Catch::WithinAbs(0.0, 1e-9));
  }
}

}  // namespace
}  // namespace concord::verification
