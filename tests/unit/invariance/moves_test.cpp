#include "compare/invariance/moves.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "compare/audit/places.h"
#include "compare/invariance/frames.h"
#include "compare/invariance/joint_frames.h"
#include "compare/invariance/modes.h"
#include "compare/invariance/order.h"
#include "compare/invariance/sides.h"
#include "compare/invariance/units.h"
#include "compare/invariance/welds.h"
#include "machines.h"

namespace concord::compare::invariance {
namespace {

constexpr double kRoundOff = 1e-12;

// Detects a move that moves nothing: the checks would compare a description with itself.
TEST(Moves, EachChangesTheDescription) {
  for (const std::string& name : all_kinds()) {
    const Model model = shipped(name);
    for (const Move& move : moves_of(model, start_of(model), {}, 7)) {
      if (move.name == "cut") continue;  // one of its descriptions may be the first one
      for (const Variant& variant : move.variants) {
        EXPECT_GT(difference(numbers_of(variant.change.model(model)), numbers_of(model), false), 0.1)
            << name << ' ' << move.name;
      }
    }
  }
}

// Detects a state that is not led back to where it came from: closings would be measured in another state.
TEST(Moves, EachLeadsAStateBack) {
  for (const std::string& name : all_kinds()) {
    const Model model = shipped(name);
    const State start = start_of(model);
    for (const Move& move : moves_of(model, start, {}, 7)) {
      for (const Variant& variant : move.variants) {
        const State back = variant.change.back(variant.change.state(start));
        EXPECT_LT(difference(numbers_of(back), numbers_of(start)), kRoundOff) << name << ' ' << move.name;
      }
    }
  }
}

// Detects coordinates that do not follow from the places of the bodies in the new description: frames that turn one
// way and coordinates the other.
TEST(Moves, CoordinatesFollowFromTheBodies) {
  for (const std::string& name : all_kinds()) {
    const Model model = shipped(name);
    const State start = start_of(model);
    for (const Move& move : moves_of(model, start, {}, 7)) {
      for (const Variant& variant : move.variants) {
        const Model told = variant.change.model(model);
        const State state = variant.change.state(start);
        for (std::size_t k = 0; k < told.joints.size(); ++k) {
          VecX q;
          VecX u;
          read_coordinates(told.joints[k], state, q, u);
          ASSERT_EQ(q.size(), state.q[k].size());
          const double sign = q.size() >= 4 && q.tail<4>().dot(state.q[k].tail<4>()) < 0.0 ? -1.0 : 1.0;
          for (Eigen::Index c = 0; c < q.size(); ++c) {
            const double other = c >= q.size() - 4 ? sign * q(c) : q(c);
            const double apart = std::remainder(other - state.q[k](c), 2.0 * EIGEN_PI);
            EXPECT_LT(std::min(std::abs(apart), std::abs(other - state.q[k](c))), 1e-9)
                << name << ' ' << move.name << ' ' << told.joints[k].name;
          }
          EXPECT_LT((u - state.u[k]).norm(), 1e-9 * (1.0 + u.norm())) << name << ' ' << move.name;
        }
      }
    }
  }
}

// Detects what a move forgets to tell anew: done twice, or there and back, it must give the first description.
TEST(Moves, ThereAndBackGivesTheSameDescription) {
  for (const std::string& name : all_kinds()) {
    const Model model = shipped(name);
    const std::vector<double> first = numbers_of(model);
    const auto expect_first = [&](const Model& again, const char* move) {
      EXPECT_LT(difference(numbers_of(again), first), kRoundOff) << name << ' ' << move;
    };
    std::vector<Pose> frames(model.bodies.size(), Pose{Vec3(0.1, -0.2, 0.3), rotation_about(Axis::x, 0.7)});
    std::vector<Pose> inverse;
    for (const Pose& pose : frames) inverse.push_back({-(pose.A.transpose() * pose.r), pose.A.transpose()});
    expect_first(with_body_frames(inverse).model(with_body_frames(frames).model(model)), "frames");
    if (freedom_of_world(model).turns) {
      expect_first(in_world(inverse[0]).model(in_world(frames[0]).model(model)), "world");
    }
    const Units units{1e3, 1e-3, 2.0, 5.0};
    const Units back{1e-3, 1e3, 0.5, 0.2};
    expect_first(told_in_units(told_in_units(model, units), back), "units");
    const PartialChange swapped = swapped_sides(model, std::nullopt);
    const Model other = swapped.change.model(model);
    expect_first(swapped_sides(other, std::nullopt).change.model(other), "sides");
  }
}

// Detects an order that is applied in one direction to bodies and in the other to joints.
TEST(Moves, OrderNamesTheSameParts) {
  const Model model = shipped("planetary_differential");
  const Model other = shuffled(model, 5).model(model);
  bool moved = false;
  for (std::size_t k = 0; k < other.joints.size(); ++k) {
    moved = moved || other.joints[k].name != model.joints[k].name;
    for (const Joint& joint : model.joints) {
      if (joint.name != other.joints[k].name) continue;
      for (const Side side : kSides) {
        EXPECT_EQ(model.bodies[joint.on(side).body].name, other.bodies[other.joints[k].on(side).body].name);
      }
    }
  }
  EXPECT_TRUE(moved);
  ASSERT_EQ(other.couplings.size(), model.couplings.size());
  for (const Coupling& coupling : other.couplings) {
    const auto same = std::find_if(model.couplings.begin(), model.couplings.end(),
                                   [&](const Coupling& one) { return one.name == coupling.name; });
    ASSERT_NE(same, model.couplings.end());
    for (std::size_t k = 0; k < coupling.terms.size(); ++k) {
      EXPECT_EQ(model.joints[same->terms[k].joint].name, other.joints[coupling.terms[k].joint].name);
    }
  }
}

/// Mass, first and second moments about the origin of `whole` of a body and of what is welded to it.
Eigen::Matrix4d moments_of_parts(const Model& model, int whole) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  const auto add = [&](const Body& body, const Pose& at) {
    const Vec3 center = at.r + at.A * body.center_of_mass_L;
    const Mat3 second = 0.5 * body.inertia_L.trace() * Mat3::Identity() - body.inertia_L;
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Mat3>(second).eigenvalues()(0), -1e-9 * body.inertia_L.norm());
    Eigen::Matrix4d moments;
    moments << body.mass, body.mass * center.transpose(), body.mass * center,
        at.A * second * at.A.transpose() + body.mass * center * center.transpose();
    sum += moments;
  };
  add(model.bodies[whole], Pose{});
  for (const Joint& joint : model.joints) {
    for (const Side side : kSides) {
      const Attachment& on_whole = joint.on(side);
      const Attachment& on_part = joint.on(side == Side::child ? Side::parent : Side::child);
      const bool is_new = joint.name.starts_with("part of ") || joint.name.starts_with("weld at ");
      if (!is_new || on_whole.body != whole || on_part.body < whole) continue;
      const Mat3 A = on_whole.C * on_part.C.transpose();
      add(model.bodies[on_part.body], {on_whole.point_L - A * on_part.point_L, A});
    }
  }
  return sum;
}

// Detects a part that takes more or less inertia than the body loses, or lies elsewhere than its weld says.
TEST(Moves, PartsAreTogetherTheBody) {
  for (const char* name : {"slider_crank_spatial_rigid", "planetary_differential", "spinning_top"}) {
    const Model model = shipped(name);
    for (const char* move : {"welds", "split"}) {
      const Model parted = moves_of(model, start_of(model), {move}, 7).front().variants.front().change.model(model);
      for (int body = 1; body < static_cast<int>(model.bodies.size()); ++body) {
        Model alone = model;
        const Eigen::Matrix4d first = moments_of_parts(alone, body);
        const double off = (moments_of_parts(parted, body) - first).norm();
        EXPECT_LT(off, kRoundOff * first.norm()) << name << ' ' << move << ' ' << model.bodies[body].name;
      }
    }
  }
}

// Detects a move that is skipped in silence.
TEST(Moves, ThoseThatDoNotApplySayWhy) {
  for (const char* name : {"compound_pendulum", "tire_test_rig", "slider_crank_spatial_flexible"}) {
    const Model model = shipped(name);
    const std::vector<Move> moves = moves_of(model, start_of(model), {}, 7);
    EXPECT_EQ(moves.size(), move_names().size());
    for (const Move& move : moves) EXPECT_EQ(move.variants.empty(), !move.why_not.empty()) << name << ' ' << move.name;
  }
  const Model pendulum = shipped("compound_pendulum");
  const std::vector<Move> of_pendulum = moves_of(pendulum, start_of(pendulum), {"cut", "modes"}, 7);
  EXPECT_EQ(of_pendulum[0].why_not, "no joint lies in a loop");
  EXPECT_EQ(of_pendulum[1].why_not, "no body is flexible");
}

// Detects a world that is turned out of its road's vertical.
TEST(Moves, TheWorldOfTiresKeepsItsVertical) {
  for (const char* name : {"tire_test_rig", "car"}) {
    const Model model = shipped(name);
    const Model moved = moved_world(model, 3).model(model);
    EXPECT_LT((moved.gravity - model.gravity).norm(), 1e-12) << name;
    EXPECT_FALSE(freedom_of_world(model).turns) << name;
  }
  EXPECT_TRUE(freedom_of_world(shipped("car_steering_step")).turns_about_vertical);
  EXPECT_FALSE(freedom_of_world(shipped("car_left_bump")).turns_about_vertical);
}

// Detects a loop joint that is never cut, and a joint of a branch that would be.
TEST(Moves, JointsOfLoopsAreFound) {
  EXPECT_TRUE(joints_in_loops(shipped("double_pendulum_3d")).empty());
  EXPECT_EQ(joints_in_loops(shipped("slider_crank_rigid")).size(), 4U);
}

// Detects flags that are passed through a rotation as if it mixed nothing.
TEST(Moves, FlagsThatARotationMixesAreUndecided) {
  std::array<bool, 6> unique{true, false, true, true, true, true};
  std::array<bool, 6> decided{true, true, true, true, true, true};
  turn_flags(rotation_about(Axis::z, 0.4), unique, decided);
  EXPECT_EQ(unique, (std::array<bool, 6>{false, false, true, true, true, true}));
  EXPECT_EQ(decided, (std::array<bool, 6>{false, false, true, true, true, true}));
  std::array<bool, 6> neither{false, false, true, true, true, true};
  decided.fill(true);
  turn_flags(rotation_about(Axis::z, 0.4), neither, decided);
  EXPECT_EQ(decided, (std::array<bool, 6>{false, false, true, true, true, true}));
  std::array<bool, 6> quarter{true, false, true, true, true, true};
  std::array<bool, 6> known{true, true, true, true, true, true};
  turn_flags(rotation_about(Axis::z, 0.5 * EIGEN_PI), quarter, known);
  EXPECT_EQ(quarter, (std::array<bool, 6>{false, true, true, true, true, true}));
  EXPECT_EQ(known, (std::array<bool, 6>{true, true, true, true, true, true}));
}

}  // namespace
}  // namespace concord::compare::invariance
