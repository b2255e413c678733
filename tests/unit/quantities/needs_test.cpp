#include "compare/quantities/needs.h"

#include <gtest/gtest.h>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

NeedOverride change(const std::string& joint, const std::string& component, double same_state,
                    const std::string& because = "") {
  return {joint, "", "", component, same_state, {}, {}, because, {"pendulum.toml", 12, 3}};
}

/// Needs of a component of a joint's reaction on its child.
Needs needs_of_reaction(const Model& model, int component) {
  return needs_of(model, {Kind::reaction, 0, Side::child, component});
}

std::string complaint(const Model& model) {
  try {
    check_needs(model);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(NeedsTest, RunsAreNotJudgedByWhatSpringsAndDampersShareOfASum) {
  const Model model = pendulum_model();
  for (const Actor actor : kActors) {
    const Needs needs = needs_of(model, {Kind::share, 0, Side::child, 0, actor});
    const bool is_law_of_state = actor == Actor::spring || actor == Actor::damper;
    EXPECT_EQ(needs.same_state, 12.0);
    EXPECT_EQ(needs.same_run, is_law_of_state ? 0.0 : 7.0);
    EXPECT_EQ(needs.refined, is_law_of_state ? 0.0 : 8.5);
  }
}

TEST(NeedsTest, FlexibleMachinesNeedLessThanRigidOnes) {
  Model model = pendulum_model();
  EXPECT_EQ(default_needs(model).same_state, 12.0);
  EXPECT_EQ(default_needs(model).same_run, 7.0);
  model.bodies[1].modal.emplace();
  EXPECT_EQ(default_needs(model).same_state, 10.0);
  EXPECT_EQ(default_needs(model).same_run, 6.0);
  EXPECT_EQ(default_needs(model).refined, 8.5);
}

TEST(NeedsTest, AModelRaisesWhatItNames) {
  Model model = pendulum_model();
  model.needs = {change("A", "T_x", 13.0)};
  EXPECT_EQ(complaint(model), "");
  EXPECT_EQ(needs_of_reaction(model, 3).same_state, 13.0);
  EXPECT_EQ(needs_of_reaction(model, 3).same_run, 7.0);
  EXPECT_EQ(needs_of_reaction(model, 0).same_state, 12.0);
  EXPECT_EQ(needs_of_reaction(model, 3).because, "");
}

TEST(NeedsTest, EmptyNamesMeanAll) {
  Model model = pendulum_model();
  model.needs = {change("", "", 13.0), change("A", "F_z", 14.0)};
  EXPECT_EQ(needs_of_reaction(model, 4).same_state, 13.0);
  EXPECT_EQ(needs_of_reaction(model, 2).same_state, 14.0);
}

TEST(NeedsTest, AJointsNeedHoldsForAllThatPassesThroughItAndForTheSumsOnItsBodies) {
  const Model model = [] {
    Model one = sprung_pendulum_model();
    one.needs = {change("A", "F_z", 5.0, "tested")};
    return one;
  }();
  const auto lowered = [&](const Quantity& quantity) { return needs_of(model, quantity).same_state == 5.0; };
  EXPECT_TRUE(lowered({Kind::reaction, 0, Side::parent, 2}));
  EXPECT_TRUE(lowered({Kind::total, 0, Side::child, 2}));
  EXPECT_TRUE(lowered({Kind::reaction_global, 0, Side::child, 0})) << "other axes mix the components";
  EXPECT_TRUE(lowered({Kind::body_sum, 1, Side::child, 1}));
  EXPECT_TRUE(lowered({Kind::tau, 0, Side::child, 0}));
  EXPECT_FALSE(lowered({Kind::reaction, 0, Side::child, 1}));
  EXPECT_FALSE(lowered({Kind::reaction_global, 0, Side::child, 4}));
  EXPECT_FALSE(lowered({Kind::element, 0, Side::child, 2}));
  EXPECT_FALSE(lowered({Kind::acceleration, 1, Side::child, 2}));
}

TEST(NeedsTest, ElementsAndBodiesHaveNeedsOfTheirOwn) {
  Model model = sprung_pendulum_model();
  model.needs = {change("", "", 5.0, "tested")};
  model.needs[0].element = "strut";
  EXPECT_EQ(needs_of(model, {Kind::element, 0, Side::child, 2}).same_state, 5.0);
  EXPECT_EQ(needs_of(model, {Kind::element, 0, Side::child, 2}).because, "tested");
  EXPECT_EQ(needs_of(model, {Kind::element, 1, Side::child, 2}).same_state, 12.0);
  EXPECT_EQ(needs_of_reaction(model, 0).same_state, 12.0);
  model.needs[0].element = "";
  model.needs[0].body = "bob";
  EXPECT_EQ(needs_of(model, {Kind::acceleration, 1, Side::child, 4}).same_state, 5.0);
  EXPECT_EQ(needs_of(model, {Kind::body_sum, 1, Side::child, 4}).same_state, 5.0);
  EXPECT_EQ(needs_of(model, {Kind::element, 0, Side::child, 2}).same_state, 12.0);
  model.needs[0].element = "strut";
  EXPECT_EQ(complaint(model),
            "pendulum.toml:12:3: error: need: it names more than one of joint, element and body; one need, one name");
  model.needs[0].element = "stut";
  model.needs[0].body = "";
  EXPECT_EQ(complaint(model), "pendulum.toml:12:3: error: need: no force element is called 'stut'");
}

TEST(NeedsTest, LoweringTakesAReason) {
  Model model = pendulum_model();
  model.needs = {change("A", "F_z", 5.0)};
  EXPECT_EQ(complaint(model),
            "pendulum.toml:12:3: error: need: same_state = 5 is below the 12 digits that the comparator asks of this "
            "model; say why with because = \"...\"");
  model.needs[0].because = "chaotic";
  EXPECT_EQ(complaint(model), "");
  EXPECT_EQ(needs_of_reaction(model, 2).same_state, 5.0);
  EXPECT_EQ(needs_of_reaction(model, 2).because, "chaotic");
}

TEST(NeedsTest, UnknownNamesAreBadInput) {
  Model model = pendulum_model();
  model.needs = {change("Q", "F_w", 13.0)};
  EXPECT_EQ(complaint(model),
            "pendulum.toml:12:3: error: need: no joint is called 'Q'\n"
            "pendulum.toml:12:3: error: need: no component is called 'F_w'; there are F_x, F_y, F_z, T_x, T_y, T_z");
}

}  // namespace
}  // namespace concord::compare
