#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
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

constexpr double kStopStiffness = 350.0;  // N m/rad
constexpr double kStopWidth = 0.004;      // rad, over which it grows

/// Where the spring's torque meets that of the stop: at the depth p, with z = p / w, c w (z^3 - z^4 / 2) up to z = 1,
/// and c (p - w / 2) beyond.
double rest_of(const Hinge& hinge) {
  const double sense = hinge.free > hinge.latch ? 1.0 : -1.0;
  double shallow = 0.0;
  double deep = std::abs(hinge.free - hinge.latch);
  for (int k = 0; k < 60; ++k) {
    const double p = 0.5 * (shallow + deep);
    const double z = p / kStopWidth;
    const double depth = z < 1.0 ? kStopWidth * (z * z * z - 0.5 * z * z * z * z) : p - 0.5 * kStopWidth;
    const bool holds = kStopStiffness * depth > hinge.stiffness * (std::abs(hinge.free - hinge.latch) - p);
    (holds ? deep : shallow) = p;
  }
  return hinge.latch + sense * shallow;
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
                    hinge.free > hinge.latch ? "upper" : "lower", hinge.latch, kStopStiffness, kStopWidth);
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

}  // namespace
}  // namespace concord::verification
