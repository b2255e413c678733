#include "cartesian/rank/uniqueness.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "common/joints/distance.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

Attachment rod_end(int body, const Vec3& at) { return testing::rigid(body, at, Mat3::Identity()); }

/// A body on rods to ground: the first two reach the same point from places that are `apart` from each other across
/// the rod, the third stands elsewhere.
Model on_rods(double apart, double scale) {
  testing::Numbers numbers(73);
  Model model;
  model.name = "rods";
  model.file = "rods.toml";
  model.bodies.resize(1);
  model.bodies.push_back(testing::make_body(numbers, "load", 0));
  const Vec3 at(0.3, -0.2, 0.5);
  const Vec3 else_at(-0.4, 0.3, 0.1);
  const Vec3 on_ground(0.3, -0.2, 1.7);
  const auto add = [&](const char* name, const Vec3& from, const Vec3& to) {
    const auto type = std::make_shared<const joints::JointType>(joints::distance_of({scale * (to - from).norm()}));
    Joint joint = testing::make_joint(numbers, model, *type, kGround, 1);
    joint.name = name;
    joint.own_type = type;
    joint.sides = {rod_end(kGround, scale * from), rod_end(1, scale * to)};
    model.joints.push_back(joint);
  };
  add("one", on_ground, at);
  add("two", on_ground + apart * Vec3(0.6, 0.8, 0.0), at);
  add("three", Vec3(0.2, 0.9, -0.4), else_at);
  return model;
}

RankReport report_at_origin(const Model& model) {
  Equations equations(model);
  VecX q = VecX::Zero(7);
  q(3) = 1.0;
  equations.update(0.0, q, VecX::Zero(6));
  return report_rank(equations);
}

bool all(const std::array<std::array<bool, 6>, 2>& flags) {
  for (const auto& side : flags) {
    for (const bool flag : side) {
      if (!flag) return false;
    }
  }
  return true;
}

TEST(Uniqueness, FlagsThatAnotherThresholdWouldChangeAreUndecided) {
  for (const double scale : {1.0, 1e-6, 1e6}) {
    SCOPED_TRACE(scale);
    const RankReport apart = report_at_origin(on_rods(1e-3, scale));
    EXPECT_EQ(apart.rank, 3);
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(all(apart.joints[k].unique));
      EXPECT_TRUE(apart.decided.empty() || all(apart.decided[k].unique));
    }
    const RankReport doubtful = report_at_origin(on_rods(3e-10, scale));
    EXPECT_TRUE(doubtful.undecided);
    EXPECT_FALSE(all(doubtful.decided[0].unique));
    EXPECT_FALSE(all(doubtful.decided[1].unique));
    EXPECT_TRUE(all(doubtful.joints[2].unique));
    EXPECT_TRUE(all(doubtful.decided[2].unique));
    const RankReport same = report_at_origin(on_rods(0.0, scale));
    EXPECT_EQ(same.rank, 2);
    EXPECT_FALSE(same.undecided);
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(all(same.decided[k].unique));
      EXPECT_EQ(all(same.joints[k].unique), k == 2);
    }
  }
}

}  // namespace
}  // namespace concord::cartesian
