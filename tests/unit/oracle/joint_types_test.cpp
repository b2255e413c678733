// Every joint type that Simbody has, or that is built from its parts: at a generic pose, with tilted frames and offset
// points, moving, in the tree and as the joint that closes a loop.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/joints/catalogue.h"
#include "compare/oracle/recipes.h"
#include "compare/quantities/observe.h"
#include "tests/unit/oracle/machines.h"

namespace concord::compare::oracle {

namespace {

/// At the same state double precision leaves 12 digits of such machines.
constexpr double kEnough = 11.5;

/// Round-off of forces of 10 N and torques of 1 N m.
constexpr double kNothing = 1e-12;

struct Word {
  std::string name;
  double q;
  double u;
  bool has_free_speed = true;
};

struct TypeCase {
  std::string type;
  std::string parameter;
  std::vector<Word> words;
  bool has_ball = false;
};

const std::vector<TypeCase>& types() {
  static const std::vector<TypeCase> all{
      {"weld", "", {}},
      {"revolute", "", {{"turn_z", 0.7, -1.9}}},
      {"translational", "", {{"slide_z", 0.35, 1.2}}},
      {"cylindrical", "", {{"slide_z", -0.3, 0.8}, {"turn_z", 2.6, 3.1}}},
      {"spherical", "", {}, true},
      {"universal", "", {{"turn_x", 0.9, -1.4}, {"turn_y", -2.2, 2.3}}},
      {"free", "", {{"slide_x", 0.2, 1.1}, {"slide_y", -0.4, 0.6}, {"slide_z", 0.3, -0.9}}, true},
      {"distance", "length = 0.62", {{"turn_x", -2.4, 1.6}, {"turn_y", 0.8, -1.1}}, true},
      {"revolute_spherical", "length = 0.47", {{"turn_z", 2.1, 1.7}}, true},
      {"universal_spherical", "length = 0.55", {{"turn_y", 0.7, 1.3}, {"turn_z", -0.9, 0.8}}, true},
      {"knife_edge", "", {{"slide_x", 0.2, 1.5}, {"slide_y", -0.3, 0.0, false}, {"turn_z", 0.8, 1.2}}},
      {"rolling_ball", "radius = 0.21", {{"slide_x", 0.2, 0.0, false}, {"slide_y", 0.4, 0.0, false}}, true},
      {"screw", "lead = 0.045", {{"turn", 4.1, 2.2}}},
  };
  return all;
}

/// What acts in the joint besides its reaction.
enum class Acting { nothing, springs, driver };

std::string start_of(const TypeCase& of, Acting acting) {
  std::string text;
  for (std::size_t k = 0; k < of.words.size(); ++k) {
    const Word& word = of.words[k];
    if (acting == Acting::driver && k == 0) {
      text += fmt::format("drive.{} = {{ law = \"polynomial\", coefficients = [{}, {}, 1.7] }}\n", word.name, word.q,
                          word.has_free_speed ? word.u : 0.4);
      continue;
    }
    text += fmt::format("start.{} = {{ keep = {}, {} = {} }}\n", word.name, word.q,
                        word.has_free_speed ? "keep_speed" : "guess_speed", word.u);
    if (acting == Acting::nothing) continue;
    text += fmt::format("spring.{} = {{ stiffness = {}, damping = 0.7, free = 0.1, actuator = 1.3 }}\n", word.name,
                        12 + 5 * static_cast<int>(k));
  }
  if (!of.has_ball) return text;
  return text + "start.ball = { keep = { rotation_vector = [0.4, -0.9, 0.6] }, keep_speed = [0.9, -1.2, 1.7] }\n";
}

std::string joint_of(const TypeCase& of, Acting acting, const std::string& parent, const std::string& child) {
  return fmt::format(R"([[joint]]
name = "x"
type = "{}"
{}
parent = {{ body = "{}", point = [0.31, -0.17, 0.23], rotation_vector = [0.5, 1.1, -0.4] }}
child = {{ body = "{}", point = [-0.12, 0.28, 0.19], rotation_vector = [-0.8, 0.3, 0.9] }}
{})",
                     of.type, of.parameter, parent, child, start_of(of, acting));
}

std::string free_body(const std::string& name, const std::string& body) {
  return fmt::format(R"([[joint]]
name = "{0}"
type = "free"
parent = {{ body = "ground", point = [0.1, 0.2, 0.3], rotation_vector = [0.2, -0.3, 0.6] }}
child = {{ body = "{1}", point = [0.05, 0.02, -0.04] }}
start.slide_x = {{ keep = 0.2, keep_speed = 0.7 }}
start.slide_y = {{ keep = -0.5, keep_speed = -0.4 }}
start.slide_z = {{ keep = 0.6, keep_speed = 0.5 }}
start.ball = {{ keep = {{ rotation_vector = [0.3, 0.8, -0.5] }}, keep_speed = [0.8, -0.6, 1.1] }}
)",
                     name, body);
}

/// Where the joint stands: Simbody's tree goes through it, or it closes a loop and a part of its child is welded on;
/// or its child is ground, or a body that is held already while nothing carries its parent.
enum class Place { tree, loop, to_ground, backwards };

std::string machine_of(const TypeCase& of, Acting acting, Place place) {
  switch (place) {
    case Place::tree:
      return kTwoBodies + free_body("held", "a") + joint_of(of, acting, "a", "b");
    case Place::loop:
      return kTwoBodies + free_body("held", "a") +
             "[[joint]]\nname = \"other\"\ntype = \"free\"\nparent = \"ground\"\nchild = \"b\"\n" +
             joint_of(of, acting, "a", "b");
    case Place::to_ground:
      return kTwoBodies + joint_of(of, acting, "a", "ground") + free_body("other", "b");
    case Place::backwards:
      return kTwoBodies + free_body("held", "a") + joint_of(of, acting, "b", "a");
  }
  return "";
}

Model model_of(const TypeCase& of, Acting acting, Place place) {
  Model model = parse_model(machine_of(of, acting, place), "machine.toml");
  if (place != Place::loop) return model;
  // Where the loop closes is known from the tree.
  const BodyState at = cartesian::make_solver(model_of(of, acting, Place::tree))->assemble().bodies[2];
  model.bodies[2].pose_guess = Pose{at.r, Eigen::Quaterniond(at.p(0), at.p(1), at.p(2), at.p(3)).toRotationMatrix()};
  return model;
}

class JointTypes : public testing::TestWithParam<std::size_t> {
 protected:
  void expect_agreement(Acting acting) const {
    const TypeCase& of = types()[GetParam()];
    for (const Place place : {Place::tree, Place::loop, Place::to_ground, Place::backwards}) {
      const Model model = model_of(of, acting, place);
      const ThirdReport report = opinion_at_start(model);
      ASSERT_EQ(report.states, 1) << report.first_failure;
      ASSERT_FALSE(report.rows.empty());
      for (const ThirdRow& row : report.rows) {
        const double off = std::max(std::abs(row.values[0] - row.values[2]), std::abs(row.values[1] - row.values[2]));
        if (off < kNothing) continue;  // a free joint carries nothing
        EXPECT_GE(row.digits(), kEnough) << of.type << ", place " << static_cast<int>(place) << ": "
                                         << describe_owner(model, row.quantity) << ", "
                                         << describe_component(row.quantity) << ": " << row.values[0] << ", "
                                         << row.values[1] << ", " << row.values[2];
      }
    }
  }
};

TEST_P(JointTypes, CarriesTheSameReactions) { expect_agreement(Acting::nothing); }

TEST_P(JointTypes, CarriesTheSameWithSprings) {
  if (!types()[GetParam()].words.empty()) expect_agreement(Acting::springs);
}

TEST_P(JointTypes, CarriesTheSameWhereItIsDriven) {
  const TypeCase& of = types()[GetParam()];
  if (of.type == "rolling_ball") return;  // its ball's speeds are kept all three or not at all, and a driver takes one
  if (!of.words.empty()) expect_agreement(Acting::driver);
}

INSTANTIATE_TEST_SUITE_P(All, JointTypes, testing::Range<std::size_t>(0, 13),
                         [](const auto& one) { return types()[one.param].type; });

TEST(JointTypesOfTheCatalogue, AreAllTriedThatHaveARecipe) {
  for (const joints::JointType* type : joints::catalogue()) {
    const bool is_tried =
        std::any_of(types().begin(), types().end(), [&](const TypeCase& of) { return of.type == type->name; });
    EXPECT_EQ(is_tried, find_recipe(type->name) != nullptr) << type->name;
  }
}

/// Couplings of turns and slides, one joint in the tree and one that closes a loop.
TEST(Couplings, ExertTheSameForce) {
  const Model model = parse_model(kTwoBodies + R"([[joint]]
name = "rack"
type = "cylindrical"
parent = { body = "ground", point = [0.1, 0.2, 0.3], rotation_vector = [0.2, -0.3, 0.6] }
child = "a"
start.slide_z = { keep = 0.2, keep_speed = 0.8 }
start.turn_z = { guess = 0.1 }
[[joint]]
name = "hook"
type = "universal"
parent = { body = "a", point = [0.3, 0.1, 0.2], rotation_vector = [0.2, 0.3, 0.1] }
child = "b"
start.turn_x = { guess = 0.4 }
start.turn_y = { keep = 0.3, keep_speed = 1.4 }
[[joint]]
name = "loose"
type = "free"
parent = "ground"
child = "b"
[[coupling]]
name = "pinion"
terms = [{ joint = "rack", coordinate = "slide_z", factor = 7 }, { joint = "rack", coordinate = "turn_z", factor = -2 }]
offset = 0.3
[[coupling]]
name = "belt"
terms = [{ joint = "rack", coordinate = "turn_z", factor = 1.5 }, { joint = "hook", coordinate = "turn_x", factor = 2 }]
)",
                                  "machine.toml");
  const ThirdReport report = opinion_at_start(model);
  ASSERT_EQ(report.states, 1) << report.first_failure;
  EXPECT_GE(report.digits(Kind::coupling).value_or(0.0), kEnough);
  EXPECT_GE(report.digits(Kind::tau).value_or(0.0), kEnough);
  EXPECT_GE(report.digits(Kind::reaction).value_or(0.0), kEnough);
  EXPECT_GE(report.digits(Kind::acceleration).value_or(0.0), kEnough);
}

}  // namespace

}  // namespace concord::compare::oracle
