#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "compare/analyses/judge.h"
#include "compare/analyses/report.h"
#include "compare/quantities/agreement.h"

/// Modes of satellites whose reaction wheels turn fast while the bus tumbles slowly: precessions of hundredths of a
/// hertz beside wheels that hardly any damping brakes.
namespace concord::verification {
namespace {

using compare::analyses::format_analysis;
using compare::analyses::judge_linearization;
using compare::analyses::Linearization;
using compare::analyses::Mode;

struct ReactionWheel {
  const char* inertia;
  const char* point;
  const char* angles;
  double speed;
};

Model satellite(const char* center, const char* rates, const std::vector<ReactionWheel>& wheels) {
  std::string text = fmt::format(
      R"toml(format = 1
[[body]]
name = "bus"
mass = 300
inertia = [90, 60, 80, -9, 3, -5]
[[joint]]
name = "free"
type = "free"
parent = "ground"
child = {{ body = "bus", point = [{}] }}
start.slide_x = {{ keep = 0, keep_speed = 0.1 }}
start.slide_y = {{ keep = 0, keep_speed = 0 }}
start.slide_z = {{ keep = 0, keep_speed = 0 }}
start.ball = {{ keep = {{ axis = [0, 0, 1], angle = 0 }}, keep_speed = [{}] }}
)toml",
      center, rates);
  for (std::size_t k = 0; k < wheels.size(); ++k) {
    text += fmt::format(
        R"toml([[body]]
name = "wheel {0}"
mass = 4
inertia = [{1}, 0.001, -0.002, 0.001]
[[joint]]
name = "axle {0}"
type = "revolute"
parent = {{ body = "bus", point = [{2}], sequence = "xyz", angles = [{3}] }}
child = {{ body = "wheel {0}" }}
start.turn_z = {{ keep = 0, keep_speed = {4} }}
spring.turn_z = {{ damping = 1e-5 }}
)toml",
        k, wheels[k].inertia, wheels[k].point, wheels[k].angles, wheels[k].speed);
  }
  return parse(text);
}

/// How near one of the eigenvalues of the whole first-order form is, as a part of the eigenvalue.
double distance_to_eigenvalues(const Linearization& found, const Mode& mode) {
  const Eigen::Index n = found.A.rows();
  MatX flow = MatX::Zero(2 * n, 2 * n);
  flow.topRightCorner(n, n).setIdentity();
  flow.bottomLeftCorner(n, n) = found.A;
  flow.bottomRightCorner(n, n) = found.B;
  const Eigen::EigenSolver<MatX> solution(flow, false);
  return (solution.eigenvalues().array() - mode.eigenvalue).abs().minCoeff() / std::abs(mode.eigenvalue);
}

bool is_resolved(const Mode& mode) {
  return !mode.is_free && !mode.is_half_of_unresolved_pair &&
         std::abs(mode.eigenvalue) > compare::kWithinResolution * mode.eigenvalue_resolution;
}

TEST_CASE("Modes of a tumbling satellite with fast wheels agree, and those that are resolved are eigenvalues",
          "[analyses][quick]") {
  const Model model =
      GENERATE(satellite("-0.119, 0.136, -0.056", "-0.029, 0.002, -0.015",
                         {{"0.0122, 0.0171, 0.0159", "-0.476, -0.217, 0.307", "-2.818, -2.13, -2.185", -150.0},
                          {"0.0167, 0.0173, 0.0169", "-0.299, -0.051, -0.034", "0.12, 0.326, 2.364", 300.0},
                          {"0.016, 0.0138, 0.016", "0.111, -0.383, 0.498", "-0.216, -2.499, 1.491", 300.0}}),
               satellite("-0.088, -0.153, -0.082", "-0.03, 0.005, -0.009",
                         {{"0.0129, 0.017, 0.0182", "0.464, -0.153, 0.215", "-0.969, 2.727, -0.183", 200.0},
                          {"0.0189, 0.0139, 0.0149", "0.306, 0.272, -0.382", "1.833, 1.487, -2.631", 100.0},
                          {"0.0143, 0.0199, 0.0168", "0.434, 0.015, 0.479", "0.628, -1.734, 1.395", -150.0},
                          {"0.0142, 0.0153, 0.0154", "-0.049, 0.423, -0.109", "-2.297, -0.405, -0.881", -150.0}}));
  const auto found = judge_linearization(model, kMakers, false);
  INFO(format_analysis(model, found, true));
  CHECK(found.wrenches.outcome == compare::Outcome::agree);
  for (const auto& linearization : found.linearizations) {
    REQUIRE(linearization);
    for (const Mode& mode : linearization->modes) {
      if (is_resolved(mode)) CHECK(distance_to_eigenvalues(*linearization, mode) < 1e-6);
    }
  }
}

}  // namespace
}  // namespace concord::verification
