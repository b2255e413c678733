#include "relative/bodies/mobilizer.h"

#include <gtest/gtest.h>

#include <numbers>

#include "machines.h"
#include "relative/bodies/exponential_map.h"

namespace concord::relative {
namespace {

class MotionOfType : public ::testing::TestWithParam<const joints::JointType*> {
 protected:
  MotionOfType() : mobilizer_(*GetParam()), numbers_(11) {
    q_ = mobilizer_.home();
    const VecX away = numbers_.vector(mobilizer_.n_u(), 1.0);
    mobilizer_.advance(q_.data(), away.data());
    u_ = numbers_.vector(mobilizer_.n_u(), 1.5);
  }

  JointMotion at(const VecX& q, const VecX& u) const {
    JointMotion motion;
    mobilizer_.evaluate(q.data(), u.data(), motion);
    return motion;
  }
  VecX moved(double h) const {
    VecX q = q_;
    const VecX step = h * u_;
    mobilizer_.advance(q.data(), step.data());
    return q;
  }

  Mobilizer mobilizer_;
  test::Numbers numbers_;
  VecX q_;
  VecX u_;
};

TEST_P(MotionOfType, ColumnsGiveTheVelocityOfTheMotion) {
  const double h = 1e-5;
  const JointMotion ahead = at(moved(h), u_);
  const JointMotion behind = at(moved(-h), u_);
  Vec6 expected;
  expected << (ahead.d - behind.d) / (2 * h), rotation_vector(ahead.R * behind.R.transpose()) / (2 * h);
  const JointMotion here = at(q_, u_);
  EXPECT_LT((here.S.leftCols(mobilizer_.n_u()) * u_ - expected).norm(), 1e-9);
  EXPECT_LT((here.v_rel - expected).norm(), 1e-9);
}

TEST_P(MotionOfType, RateOfTheColumnsIsTheirDerivative) {
  const double h = 1e-5;
  const Vec6 expected = (at(moved(h), u_).v_rel - at(moved(-h), u_).v_rel) / (2 * h);
  EXPECT_LT((at(q_, u_).Sdot_u - expected).norm(), 1e-9);
}

TEST_P(MotionOfType, RatesOfCoordinatesFollowTheSpeeds) {
  const double h = 1e-5;
  VecX qdot(mobilizer_.n_q());
  mobilizer_.compute_qdot(q_.data(), u_.data(), qdot.data());
  EXPECT_LT((qdot - (moved(h) - moved(-h)) / (2 * h)).norm(), 1e-9);
}

TEST_P(MotionOfType, StartsAtHomeWithTheFramesTogetherButForItsArms) {
  const JointMotion home = at(mobilizer_.home(), u_);
  Vec3 arms = Vec3::Zero();
  for (const joints::Permit& word : GetParam()->permits) {
    if (const auto* arm = std::get_if<joints::Arm>(&word)) arms += arm->length * Vec3::Unit(index(arm->axis));
  }
  if (GetParam()->name == "spiral") arms = Vec3(0.3, 0.0, 0.0);
  EXPECT_LT((home.d - arms).norm(), 1e-16);
  EXPECT_EQ((home.R - Mat3::Identity()).norm(), 0.0);
}

TEST_P(MotionOfType, CoordinateWrenchDoesTheWorkOfItsForces) {
  VecX tau = numbers_.vector(mobilizer_.n_u(), 2.0);
  const JointMotion here = at(q_, u_);
  const Vec6 w = mobilizer_.coordinate_wrench(here, tau);
  EXPECT_LT((here.S.leftCols(mobilizer_.n_u()).transpose() * w - tau).norm(), 1e-14);
}

TEST_P(MotionOfType, IsOfFullRankInAGeneralPose) { EXPECT_FALSE(mobilizer_.loses_rank(at(q_, u_))); }

INSTANTIATE_TEST_SUITE_P(Catalogue, MotionOfType, ::testing::ValuesIn(test::all_types()),
                         [](const auto& tested) { return tested.param->name; });

TEST(Mobilizer, RefusesWordsInAnOrderThatTheVocabularyExcludes) {
  const joints::JointType slide_after_turn{"odd", {}, {joints::Turn{Axis::x}, joints::Slide{Axis::y}}, {}};
  const joints::JointType word_after_ball{"odd", {}, {joints::Ball{}, joints::Turn{Axis::y}}, {}};
  const joints::JointType turn_lost_in_ball{"odd", {}, {joints::Turn{Axis::x}, joints::Ball{}}, {}};
  const joints::JointType functions_and_more{"odd", {}, {test::type_named("spiral")->permits[0], joints::Ball{}}, {}};
  EXPECT_THROW(Mobilizer{slide_after_turn}, std::invalid_argument);
  EXPECT_THROW(Mobilizer{word_after_ball}, std::invalid_argument);
  EXPECT_THROW(Mobilizer{turn_lost_in_ball}, std::invalid_argument);
  EXPECT_THROW(Mobilizer{functions_and_more}, std::invalid_argument);
}

TEST(Mobilizer, RefusesAFourthSlideOrTurn) {
  const joints::Slide x{Axis::x};
  const joints::Turn z{Axis::z};
  const joints::JointType slides{"odd", {}, {x, joints::Slide{Axis::y}, joints::Slide{Axis::z}, x}, {}};
  const joints::JointType turns{"odd", {}, {z, joints::Turn{Axis::x}, joints::Turn{Axis::y}, z}, {}};
  EXPECT_THROW(Mobilizer{slides}, std::invalid_argument);
  EXPECT_THROW(Mobilizer{turns}, std::invalid_argument);
}

/// Whether the motion of a type loses rank at its first coordinates, the others at home.
bool loses_rank_at(const joints::JointType& type, const std::vector<double>& first) {
  const Mobilizer mobilizer(type);
  VecX q = mobilizer.home();
  for (std::size_t c = 0; c < first.size(); ++c) q(static_cast<Eigen::Index>(c)) = first[c];
  JointMotion reached;
  mobilizer.evaluate(q.data(), VecX::Zero(mobilizer.n_u()).eval().data(), reached);
  return mobilizer.loses_rank(reached);
}

TEST(Mobilizer, LosesRankWhereTwoSpeedsDoTheSame) {
  // A rod along the parent's x; a link along the parent's y; the middle of three turns at a quarter turn.
  EXPECT_TRUE(loses_rank_at(*joints::find("distance"), {0.7, M_PI / 2.0 - 1e-7}));
  EXPECT_FALSE(loses_rank_at(*joints::find("distance"), {0.7, M_PI / 2.0 - 1e-5}));
  EXPECT_TRUE(loses_rank_at(*joints::find("universal_spherical"), {-0.4, M_PI / 2.0}));
  const joints::JointType gimbal{
      "gimbal", {}, {joints::Turn{Axis::z}, joints::Turn{Axis::y}, joints::Turn{Axis::x}}, {}};
  EXPECT_TRUE(loses_rank_at(gimbal, {0.2, M_PI / 2.0, 0.1}));
  EXPECT_FALSE(loses_rank_at(gimbal, {0.2, 1.5, 0.1}));
  EXPECT_FALSE(loses_rank_at(*joints::find("universal"), {0.2, M_PI / 2.0}));
}

TEST(Mobilizer, PutsForcesOnSlidesAndTorquesOnTurns) {
  test::Numbers numbers(8);
  const auto wrench_of = [&](const char* type, const std::vector<double>& tau) {
    const Mobilizer mobilizer(*test::type_named(type));
    VecX q = mobilizer.home();
    const VecX away = numbers.vector(mobilizer.n_u(), 0.8);
    mobilizer.advance(q.data(), away.data());
    JointMotion reached;
    mobilizer.evaluate(q.data(), VecX::Zero(mobilizer.n_u()).eval().data(), reached);
    JointVector forces = JointVector::Zero(mobilizer.n_u());
    for (std::size_t c = 0; c < tau.size(); ++c) forces(static_cast<Eigen::Index>(c)) = tau[c];
    return mobilizer.coordinate_wrench(reached, forces);
  };
  // A knee slides along y; its arms put no force anywhere else.
  const Vec6 knee = wrench_of("knee", {0.4, 1.3, -0.7});
  EXPECT_EQ(Vec3(knee.head<3>()).cross(Vec3::UnitY()).norm(), 0.0);
  EXPECT_GT(knee.tail<3>().norm(), 0.1);
  // A rod's turns are felt as forces at the ball.
  const Vec6 rod = wrench_of("distance", {1.3, -0.7});
  EXPECT_EQ(rod.tail<3>().norm(), 0.0);
  EXPECT_GT(rod.head<3>().norm(), 0.1);
}

TEST(Mobilizer, NamesAPoseOfALinkByItsElevation) {
  const Mobilizer mobilizer(*joints::find("distance"));
  VecX q = mobilizer.home();
  q.head<2>() << 0.4, 2.5;
  JointMotion before;
  const VecX still = VecX::Zero(mobilizer.n_u());
  mobilizer.evaluate(q.data(), still.data(), before);
  VecX near = mobilizer.home();
  near(0) = 13.0;
  mobilizer.choose_chart(q.data(), near.data());
  EXPECT_NEAR(q(1), M_PI - 2.5, 1e-15);
  EXPECT_NEAR(q(0), 0.4 + 5.0 * M_PI, 1e-14);
  JointMotion after;
  mobilizer.evaluate(q.data(), still.data(), after);
  EXPECT_LT((after.d - before.d).norm(), 1e-15);
}

TEST(Mobilizer, NormalizesEulerParametersOnly) {
  const Mobilizer mobilizer(*joints::find("free"));
  VecX q(7);
  q << 0.3, 0.4, 0.5, 2.0, -2.0, 4.0, 1.0;
  mobilizer.normalize(q.data());
  VecX expected(7);
  expected << 0.3, 0.4, 0.5, 0.4, -0.4, 0.8, 0.2;
  EXPECT_LT((q - expected).norm(), 1e-15);
}

/// A thread stands where its turns have brought it, turned by what is left beside them.
TEST(Mobilizer, LosesNoDigitsOfAThreadAfterManyTurns) {
  Mobilizer thread(*test::type_named("screw"));
  const double u = 1.3;
  JointMotion first;
  double q = 0.4;
  thread.evaluate(&q, &u, first);
  for (const double turns : {-3.0, 90.0, 1e4}) {
    thread.count_turns(&turns);
    JointMotion then;
    thread.evaluate(&q, &u, then);
    const double height = first.d.z() / 0.4 * (0.4 + 2.0 * std::numbers::pi * turns);
    EXPECT_NEAR(then.d.z(), height, 1e-15 * std::abs(height));
    EXPECT_LT((then.R - first.R).norm(), 1e-15 + 1e-18 * std::abs(turns)) << turns;
    EXPECT_LT((then.S.col(0) - first.S.col(0)).norm(), 1e-15);
    EXPECT_LT((then.v_rel - first.v_rel).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace concord::relative
