#include "compare/states/chart.h"

#include <gtest/gtest.h>

#include "common/reading/model_file.h"

namespace concord::compare {
namespace {

/// A rod that twists, with nothing attached but at its root, or with a load at its tip.
Model twisting_rod(const std::string& load) {
  return parse_model(R"(format = 1
[[body]]
name = "rod"
[body.beam]
length = 0.9
section = { diameter = 0.01 }
youngs_modulus = 2e11
poissons_ratio = 0.3
density = 7800
support = "cantilever"
modes = { torsion = [1] }
elements = 6
[[joint]]
name = "clamp"
type = "weld"
parent = "ground"
child = { body = "rod", node = "first" }
)" + load,
                     "rod.toml");
}

TEST(ModalSizesTest, CountHowFarAModeTurnsWhatIsAttached) {
  const Model bare = twisting_rod("");
  const Model loaded = twisting_rod("[[load]]\nname = \"tip\"\nbody = \"rod\"\nnode = \"last\"\ntorque = [1, 0, 0]\n");
  const double deflection = largest_deflections(bare.bodies[1])(0) / bare.length_scale();
  EXPECT_EQ(modal_sizes(bare, 1)(0), deflection);
  const double turn = end_of(loaded.elements[0], Side::child)->Psi_r_L.col(0).norm();
  EXPECT_GT(turn, 10.0 * largest_deflections(loaded.bodies[1])(0) / loaded.length_scale());
  EXPECT_EQ(modal_sizes(loaded, 1)(0), turn);
}

}  // namespace
}  // namespace concord::compare
