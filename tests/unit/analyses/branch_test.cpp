#include "compare/analyses/branch.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"

namespace concord::compare::analyses {
namespace {

/// A crank of 0.3 m at an angle and a rod that takes a slide along; a second hinge of the crank is redundant.
struct SliderCrank {
  Model model;
  State state;

  SliderCrank(double turn, double rod, double guess, bool has_second_hinge)
      : SliderCrank(text(turn, rod, guess, has_second_hinge)) {}

  explicit SliderCrank(const std::string& text)
      : model(parse_model(text, "slider_crank.toml")), state(cartesian::make_solver(model)->assemble()) {}

  static std::string text(double turn, double rod, double guess, bool has_second_hinge) {
    std::string text = "format = 1\n[[body]]\nname = \"crank\"\nmass = 1\ninertia = [1, 1, 1]\n";
    const std::string hinge = "[[joint]]\nname = \"{}\"\ntype = \"revolute\"\n";
    if (has_second_hinge) {
      text +=
          fmt::format(fmt::runtime(hinge), "second") +
          "parent = { body = \"ground\", point = [0, 0, 0.1] }\nchild = { body = \"crank\", point = [0, 0, 0.1] }\n";
    }
    text += fmt::format(fmt::runtime(hinge), "shaft") + "parent = \"ground\"\nchild = \"crank\"\n" +
            fmt::format("drive.turn_z = {{ law = \"polynomial\", coefficients = [{}, 1] }}\n", turn);
    return text + linkage("", turn, rod, guess);
  }

  /// A rod on the crank and its slide, which is guessed there.
  static std::string linkage(const std::string& mark, double turn, double rod, double guess) {
    std::string text;
    for (const char* body : {"rod", "slide"}) {
      text += fmt::format("[[body]]\nname = \"{}{}\"\nmass = 1\ninertia = [1, 1, 1]\n", body, mark);
    }
    const double aslant = std::atan2(-0.3 * std::sin(turn), guess - 0.3 * std::cos(turn));
    const auto hinge = [&](const char* name, const std::string& parent, double x, const char* child, double angle) {
      return fmt::format(
          "[[joint]]\nname = \"{0}{1}\"\ntype = \"revolute\"\nparent = {{ body = \"{2}\", point = [{3}, 0, 0] }}\n"
          "child = \"{4}{1}\"\nstart.turn_z = {{ guess = {5} }}\n",
          name, mark, parent, x, child, angle);
    };
    text += hinge("pin", "crank", 0.3, "rod", aslant - turn);
    text += hinge("gudgeon", "rod" + mark, rod, "slide", -aslant);
    text += fmt::format(
        "[[joint]]\nname = \"way{0}\"\ntype = \"translational\"\nboth = {{ x = [0, 1, 0], z = [1, 0, 0] }}\n"
        "parent = \"ground\"\nchild = \"slide{0}\"\n",
        mark);
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
      EXPECT_TRUE(are_on_one_branch(first.model, block_triangular_form(first.model), first.state, other.state))
          << turn << (second ? " redundant" : "");
    }
  }
}

TEST(Branch, IsAnotherOneOnTheOtherSideOfTheCrank) {
  for (const bool second : {false, true}) {
    const SliderCrank first(1.1, 0.5, 0.6, second);
    const double along = 0.3 * std::cos(1.2) - std::sqrt(0.25 - 0.09 * std::sin(1.2) * std::sin(1.2));
    const SliderCrank other(1.2, 0.5, along, second);
    ASSERT_NEAR(other.state.bodies[3].r.x(), along, 1e-9);
    EXPECT_FALSE(are_on_one_branch(first.model, block_triangular_form(first.model), first.state, other.state))
        << (second ? " redundant" : "");
  }
}

// The signs of two equal linkages change together, and with them not that of the whole machine.
TEST(Branch, IsAnotherOneWhereTwoLinkagesLeapTogether) {
  const auto along = [](double turn, double sign) {
    return 0.3 * std::cos(turn) + sign * std::sqrt(0.25 - 0.09 * std::sin(turn) * std::sin(turn));
  };
  const auto twins = [&](double turn, double first, double second) {
    return SliderCrank(SliderCrank::text(turn, 0.5, along(turn, first), false) +
                       SliderCrank::linkage("2", turn, 0.5, along(turn, second)));
  };
  const SliderCrank start = twins(1.1, 1.0, 1.0);
  for (const auto& [first, second] : {std::pair(1.0, 1.0), {1.0, -1.0}, {-1.0, 1.0}, {-1.0, -1.0}}) {
    const SliderCrank later = twins(1.2, first, second);
    ASSERT_NEAR(later.state.bodies[3].r.x(), along(1.2, first), 1e-9);
    ASSERT_NEAR(later.state.bodies[5].r.x(), along(1.2, second), 1e-9);
    EXPECT_EQ(are_on_one_branch(start.model, block_triangular_form(start.model), start.state, later.state),
              first > 0.0 && second > 0.0)
        << first << " " << second;
  }
}

}  // namespace
}  // namespace concord::compare::analyses
