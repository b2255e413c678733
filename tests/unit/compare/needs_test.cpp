#include "compare/needs.h"

#include <gtest/gtest.h>

#include "fake_pendulum.h"

namespace concord::compare {
namespace {

NeedOverride change(const std::string& joint, const std::string& component, double same_state,
                    const std::string& because = "") {
  return {joint, component, same_state, {}, {}, because, {"pendulum.toml", 12, 3}};
}

std::string complaint(const Model& model) {
  try {
    check_needs(model);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
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
  EXPECT_EQ(needs_of(model, "A", "T_x").same_state, 13.0);
  EXPECT_EQ(needs_of(model, "A", "T_x").same_run, 7.0);
  EXPECT_EQ(needs_of(model, "A", "F_x").same_state, 12.0);
  EXPECT_EQ(needs_of(model, "A", "T_x").because, "");
}

TEST(NeedsTest, EmptyNamesMeanAll) {
  Model model = pendulum_model();
  model.needs = {change("", "", 13.0), change("A", "F_z", 14.0)};
  EXPECT_EQ(needs_of(model, "A", "T_y").same_state, 13.0);
  EXPECT_EQ(needs_of(model, "A", "F_z").same_state, 14.0);
}

TEST(NeedsTest, LoweringTakesAReason) {
  Model model = pendulum_model();
  model.needs = {change("A", "F_z", 5.0)};
  EXPECT_EQ(complaint(model),
            "pendulum.toml:12:3: error: need: same_state = 5 is below the 12 digits that the comparator asks of this "
            "model; say why with because = \"...\"");
  model.needs[0].because = "chaotic";
  EXPECT_EQ(complaint(model), "");
  EXPECT_EQ(needs_of(model, "A", "F_z").same_state, 5.0);
  EXPECT_EQ(needs_of(model, "A", "F_z").because, "chaotic");
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
