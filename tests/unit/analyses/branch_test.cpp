#include "compare/analyses/branch.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"

namespace concord::compare::analyses {
namespace {

/// A crank of 0.3 m at an angle and a rod that takes a slide along; a second hinge of the crank is redundant.
struct SliderCrank {
  Model model;
  State state;

  SliderCrank(double turn, double rod, double guess, bool has_second_hinge)
      : model(parse_model(text(turn, rod, guess, has_second_hinge), "slider_crank.toml")),
        state(cartesian::make_solver(model)->assemble()) {}

  static std::string text(double turn, double rod, double guess, bool has_second_hinge) {
    std::string text = "format = 1\n";
    for (const char* body : {"crank", "rod", "slide"}) {
      text += fmt::format("[[body]]\nname = \"{}\"\nmass = 1\ninertia = [1, 1, 1]\n", body);
    }
    const std::string hinge = "[[joint]]\nname = \"{}\"\ntype = \"revolute\"\n";
    if (has_second_hinge) {
      text +=
          fmt::format(fmt::runtime(hinge), "second") +
          "parent = { body = \"ground\", point = [0, 0, 0.1] }\nchild = { body = \"crank\", point = [0, 0, 0.1] }\n";
    }
    text += fmt::format(fmt::runtime(hinge), "shaft") + "parent = \"ground\"\nchild = \"crank\"\n" +
            fmt::format("drive.turn_z = {{ law = \"polynomial\", coefficients = [{}, 1] }}\n", turn);
    const double aslant = std::atan2(-0.3 * std::sin(turn), guess - 0.3 * std::cos(turn));
    text += fmt::format(fmt::runtime(hinge), "pin") +
            "parent = { body = \"crank\", point = [0.3, 0, 0] }\nchild = \"rod\"\n" +
            fmt::format("start.turn_z = {{ guess = {} }}\n", aslant - turn);
    text += fmt::format(fmt::runtime(hinge), "gudgeon") +
            fmt::format("parent = {{ body = \"rod\", point = [{}, 0, 0] }}\nchild = \"slide\"\n", rod) +
            fmt::format("start.turn_z = {{ guess = {} }}\n", -aslant);
    text +=
        "[[joint]]\nname = \"way\"\ntype = \"translational\"\nboth = { x = [0, 1, 0], z = [1, 0, 0] }\n"
        "parent = \"ground\"\nchild = \"slide\"\n";
    return text + fmt::format("start.slide_z = {{ guess = {} }}\n", guess);
  }
};

TEST(Branch, IsTheSameAllRoundTheTurnOfACrank) {
  for (const bool second : {false, true}) {
    const SliderCrank first(0.3, 0.5, 0.75, second);
    for (const double turn : {1.4, 1.8, 2.9, 4.0, 5.9}) {
      const double along = 0.3 * std::cos(turn) + std::sqrt(0.25 - 0.09 * std::sin(turn) * std::sin(turn));
      const SliderCrank other(turn, 0.5, along, second);
      ASSERT_NEAR(other.state.bodies[3].r.x(), along, 1e-9);
      EXPECT_TRUE(are_on_one_branch(first.model, first.state, other.state)) << turn << (second ? " redundant" : "");
    }
  }
}

TEST(Branch, IsAnotherOneOnTheOtherSideOfTheCrank) {
  for (const bool second : {false, true}) {
    const SliderCrank first(1.1, 0.5, 0.6, second);
    const double along = 0.3 * std::cos(1.2) - std::sqrt(0.25 - 0.09 * std::sin(1.2) * std::sin(1.2));
    const SliderCrank other(1.2, 0.5, along, second);
    ASSERT_NEAR(other.state.bodies[3].r.x(), along, 1e-9);
    EXPECT_FALSE(are_on_one_branch(first.model, first.state, other.state)) << (second ? " redundant" : "");
  }
}

}  // namespace
}  // namespace concord::compare::analyses
