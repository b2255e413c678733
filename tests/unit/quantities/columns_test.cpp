#include "compare/quantities/columns.h"

#include <gmock/gmock.h>

#include <set>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

TEST(Columns, HaveNamesOfTheirOwnAndSayWhatTheyAre) {
  const Model model = sprung_pendulum_model();
  std::set<std::string> names;
  std::size_t count = 0;
  for (const auto& columns :
       {motion_columns(model), reaction_columns(model), element_columns(model), further_columns(model)}) {
    for (const Column& column : columns) {
      names.insert(column.name);
      EXPECT_FALSE(column.unit.empty()) << column.name;
      EXPECT_TRUE(column.name.ends_with(describe_component(column))) << column.name;
      EXPECT_FALSE(describe_owner(model, column).empty()) << column.name;
      ++count;
    }
  }
  EXPECT_EQ(names.size(), count);
  for (const char* name :
       {"bob.x", "bob.e3", "bob.omegadot_z", "A.q_1", "A.parent.T_z", "A.tau_1", "A.child.total.F_x",
        "A.child.global.F_x", "A.parent.total_global.T_y", "rubber.parent.F_x", "push.child.global.T_z"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
  EXPECT_FALSE(names.contains("push.parent.F_x"));  // a load has no parent
}

TEST(Columns, DescribeTheirOwners) {
  const Model model = sprung_pendulum_model();
  const auto owner_of = [&](const std::string& name) {
    for (const auto& columns : {motion_columns(model), reaction_columns(model), further_columns(model)}) {
      for (const Column& column : columns) {
        if (column.name == name) return describe_owner(model, column);
      }
    }
    return std::string("none");
  };
  EXPECT_EQ(owner_of("bob.v_x"), "body bob");
  EXPECT_EQ(owner_of("bob.vdot_x"), "body bob");
  EXPECT_EQ(owner_of("A.q_1"), "joint A");
  EXPECT_EQ(owner_of("A.tau_1"), "joint A");
  EXPECT_EQ(owner_of("A.child.F_x"), "joint A on bob");
  EXPECT_EQ(owner_of("A.parent.total.F_x"), "joint A on ground (total wrench)");
  EXPECT_EQ(owner_of("A.parent.total_global.F_x"), "joint A on ground (total wrench, global axes)");
  EXPECT_EQ(owner_of("rubber.child.global.F_x"), "force element rubber on bob (global axes)");
}

}  // namespace
}  // namespace concord::compare
