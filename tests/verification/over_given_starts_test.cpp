#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>

#include "common/reading/text_file.h"
#include "compare/audit/kept_start.h"
#include "judged_machines.h"

/// Starts that keep more than their machine has freedoms, with the spatial slider-crank: one freedom, a tilted world.
namespace concord::verification {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// The slider-crank with these keys of the start of its slide, whose place at the start is 0.157956287 m.
Model slider_crank(const std::string& slide, const std::string& turn = "") {
  std::string text = read_text_file(CONCORD_DATA "/models/slider_crank_spatial_rigid.toml");
  const auto put = [&](const std::string& from, const std::string& to) {
    REQUIRE(text.find(from) != std::string::npos);
    text.replace(text.find(from), from.size(), to);
  };
  put("start.slide_z = { guess = 0.158 }", fmt::format("start.slide_z = {{ {} }}", slide));
  if (!turn.empty()) put("start.turn_x = { guess = \"2 deg\" }", fmt::format("start.turn_x = {{ {} }}", turn));
  return parse_model(text, "slider_crank.toml");
}

using Maker = std::unique_ptr<Solver> (*)(const Model&);
constexpr std::array<Maker, 2> kMakers{cartesian::make_solver, relative::make_solver};

std::string refusal_of(const Model& model, Maker make) {
  try {
    static_cast<void>(make(model)->assemble());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

const std::string kContradict =
    "the start keeps more than the machine has freedoms, and the values contradict each other: with turn_z of joint "
    "'A' as kept, ";

TEST_CASE("A start may keep more than the machine has freedoms, if the digits that are written agree", "[start]") {
  const Model given = slider_crank("keep = 0.158", "keep = \"1.6 deg\"");
  for (const Maker make : kMakers) {
    const std::unique_ptr<Solver> solver = make(given);
    INFO(solver->name());
    const State start = solver->assemble();
    const State guessed = make(slider_crank("guess = 0.158"))->assemble();
    CHECK(std::abs(start.q[0](0) - 75.0 * kDegree) < 1e-12);  // the first one exactly
    for (std::size_t k = 0; k < start.q.size(); ++k) CHECK((start.q[k] - guessed.q[k]).norm() < 1e-9);
    CHECK(std::abs(start.u[0](0) - 50.0) < 1e-9);
    CHECK(compare::audit_kept_start(given, start).holds());
  }
  expect_to_agree(given, in_short(given, 0.2));
}

TEST_CASE("Which of too many kept values are met exactly, their order in the file decides", "[start]") {
  Model model = slider_crank("keep = 0.158");
  std::swap(model.joints[0], model.joints[3]);
  for (const Maker make : kMakers) {
    // 75 deg is no decimal fraction, so it is meant exactly: the slide, which comes first, leads elsewhere.
    CHECK_THAT(refusal_of(model, make),
               Catch::Contains("with slide_z of joint 'D' as kept, turn_z of joint 'A' is 1.3"));
    model.joints[3].start[0].slack_q(0) = 1e-3;
    const State start = make(model)->assemble();
    CHECK(std::abs(start.q[0](0) - 0.158) < 1e-12);
    CHECK(std::abs(start.q[3](0) - 75.0 * kDegree) > 1e-6);
    model.joints[3].start[0].slack_q(0) = kWrittenExactly;
  }
}

TEST_CASE("Kept values that contradict each other are refused with what is found and what is written", "[start]") {
  for (const Maker make : kMakers) {
    CHECK_THAT(refusal_of(slider_crank("keep = 0.159"), make),
               Catch::Contains(kContradict + "slide_z of joint 'D' is 0.157956287") &&
                   Catch::Contains(", where 0.159 is kept to 0.0005: correct these values, or keep fewer"));
    CHECK(refusal_of(slider_crank("keep = 0.16"), make).empty());
    CHECK_THAT(refusal_of(slider_crank("keep = \"0.158\" "), make), Catch::Equals(""));
    CHECK_THAT(refusal_of(slider_crank("keep = \"2 * 0.079\""), make), Catch::Contains("is kept to 1e-09"));
    CHECK_THAT(refusal_of(slider_crank("keep = 0.15796, keep_speed = 0.0"), make),
               Catch::Contains("the speed of slide_z of joint 'D' is ") && Catch::Contains("where 0 is kept to 0.05"));
  }
}

TEST_CASE("As many kept values as a machine has freedoms are met exactly, whatever their digits leave open",
          "[start]") {
  const Model model = slider_crank("guess = 0.158");
  State start = cartesian::make_solver(model)->assemble();
  Model kept = model;
  kept.joints[0].start[0].slack_q = VecX::Constant(1, 0.05);
  start.q[0](0) += 1e-3;
  CHECK_FALSE(compare::audit_kept_start(kept, start).holds());
}

}  // namespace
}  // namespace concord::verification
