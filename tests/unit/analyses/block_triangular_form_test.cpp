#include <gtest/gtest.h>

#include <string>

#include "common/reading/model_file.h"
#include "compare/analyses/branch.h"

namespace concord::compare::analyses {
namespace {

std::string body(const std::string& name) {
  return "[[body]]\nname = \"" + name + "\"\nmass = 1\ninertia = [1, 1, 1]\n";
}

std::string hinge(const std::string& parent, const std::string& child, const std::string& more = "") {
  return "[[joint]]\nname = \"" + parent + "_" + child + "\"\ntype = \"revolute\"\nparent = \"" + parent +
         "\"\nchild = \"" + child + "\"\n" + more;
}

// A driven crank and a driven link on it, stated first: each block is square.
TEST(BlockTriangularForm, FollowsDriversFromTheGroundOn) {
  const std::string drive = "drive.turn_z = { law = \"polynomial\", coefficients = [0, 1] }\n";
  const Model model = parse_model(
      "format = 1\n" + body("a") + body("b") + hinge("a", "b", drive) + hinge("ground", "a", drive), "chain.toml");
  const std::vector<Block> blocks = block_triangular_form(model);
  ASSERT_EQ(blocks.size(), 4U);  // two speeds, two bodies
  for (const Block& block : blocks) EXPECT_EQ(block.rows.size(), block.columns.size());
  EXPECT_EQ(blocks[0].columns, std::vector<Eigen::Index>{12});
  EXPECT_EQ(blocks[2].columns.front(), 0);
  EXPECT_EQ(blocks[3].columns.front(), 6);
}

TEST(BlockTriangularForm, LeavesPartsThatShareNothingApart) {
  const Model model = parse_model("format = 1\n" + body("a") + body("b") + body("c") + hinge("ground", "a") +
                                      hinge("a", "b") + hinge("ground", "c"),
                                  "parts.toml");
  const std::vector<Block> blocks = block_triangular_form(model);
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_EQ(blocks[0].columns.size(), 14U);  // two bodies, two speeds; free: fewer rows
  EXPECT_EQ(blocks[0].rows.size(), 12U);
  EXPECT_EQ(blocks[1].columns.size(), 7U);
  EXPECT_EQ(blocks[1].rows.size(), 6U);
}

}  // namespace
}  // namespace concord::compare::analyses
