#include "compare/attribution/ranks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/joints/spherical.h"
#include "compare/attribution/attribution.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// What a right and a wrong solver say of the constraints of a pendulum with a ball on its axis, in some states.
class RanksTest : public ::testing::Test {
 protected:
  RanksTest() {
    pendulum_ = std::make_unique<FakePendulum>(model_, "pendulum");
    RunOptions run;
    run.until = 0.4;
    run.samples = 4;
    for (const Sample& sample : pendulum_->integrate(run, {}).samples) {
      AskedState& one = asked_.emplace_back();
      one.state = sample.state;
      for (StatedConstraints& stated : one.by) {
        stated.rank = MachineConstraints(model_, sample.state).report();
        stated.tangent = pendulum_->tangent(sample.state);
        stated.closed = sample.state;
        stated.answer = StatedConstraints::Answer::given;
      }
    }
  }

  void add_ball() {
    Joint ball = model_.joints[0];
    ball.name = "ball";
    ball.type = &joints::spherical;
    for (Attachment& side : ball.sides) side.point_L += side.C.col(2) * 0.2;
    ball.start = {{}};
    model_.joints.push_back(ball);
    for (AskedState& one : asked_) {
      for (StatedConstraints& stated : one.by) stated.rank = MachineConstraints(model_, one.state).report();
    }
  }

  void expect(const std::optional<ConstraintFault>& fault, Term term, const std::string& where) {
    ASSERT_TRUE(fault);
    EXPECT_EQ(fault->solver, 1) << fault->because;
    EXPECT_STREQ(name_of(fault->term), name_of(term)) << fault->because;
    EXPECT_EQ(fault->where, where) << fault->because;
  }

  Model model_ = pendulum_model();
  std::unique_ptr<FakePendulum> pendulum_;
  std::vector<AskedState> asked_;
};

TEST_F(RanksTest, NobodyIsBlamedWhereAllIsRight) {
  ConstraintOpinion opinion(model_, asked_);
  EXPECT_FALSE(opinion.wrong_count());
  EXPECT_FALSE(opinion.wrong_velocities());
  EXPECT_FALSE(opinion.wrongly_closed());
  EXPECT_FALSE(opinion.wrongly_singular());
  EXPECT_FALSE(opinion.wrong_uniqueness());
  EXPECT_FALSE(find_cause_of_stop(model_, asked_));
}

TEST_F(RanksTest, AnotherCountIsARank) {
  for (AskedState& one : asked_) {
    --one.by[1].rank->rank;
    ++one.by[1].rank->degrees_of_freedom;
  }
  const auto fault = ConstraintOpinion(model_, asked_).wrong_count();
  expect(fault, Term::rank, "the machine as a whole");
  EXPECT_NE(fault->because.find("finds rank 4 of 5 constraints and 2 degrees of freedom; the joints themselves give 5 "
                                "of 5 and 1 (by the comparator's own count, in 5 of 5 states"),
            std::string::npos)
      << fault->because;
}

/// The rank is lower because a row is wrong: the velocities are none that the joints permit.
TEST_F(RanksTest, AnotherCountOfOtherVelocitiesIsAJacobian) {
  for (AskedState& one : asked_) {
    --one.by[1].rank->rank;
    ++one.by[1].rank->degrees_of_freedom;
    one.by[1].tangent(3) += 0.1;
  }
  expect(ConstraintOpinion(model_, asked_).wrong_count(), Term::jacobian, "joint A");
}

TEST_F(RanksTest, OtherVelocitiesAreAJacobianWhateverTheirCount) {
  for (AskedState& one : asked_) one.by[1].tangent(3) += 0.1;
  expect(ConstraintOpinion(model_, asked_).wrong_velocities(), Term::jacobian, "joint A");
}

TEST_F(RanksTest, AnOpenClosedStateIsAJacobian) {
  for (AskedState& one : asked_) one.by[1].closed->bodies[1].r += Vec3(0, 1e-3, 0);
  expect(ConstraintOpinion(model_, asked_).wrongly_closed(), Term::jacobian, "joint A");
}

TEST_F(RanksTest, RegularPosesCalledSingularAreARank) {
  for (AskedState& one : asked_) one.by[1].answer = StatedConstraints::Answer::singular;
  expect(ConstraintOpinion(model_, asked_).wrongly_singular(), Term::rank, "the machine as a whole");
  // Where the other one does not go on either, nobody knows.
  for (AskedState& one : asked_) one.by[0].answer = StatedConstraints::Answer::singular;
  EXPECT_FALSE(ConstraintOpinion(model_, asked_).wrongly_singular());
}

TEST_F(RanksTest, ASelfStressOverlookedIsARankOfItsJoints) {
  add_ball();
  for (AskedState& one : asked_) one.by[1].rank->joints[0].unique[0][2] = true;
  const auto fault = ConstraintOpinion(model_, asked_).wrong_uniqueness();
  expect(fault, Term::rank, "joint A, joint ball");
  EXPECT_TRUE(fault->because.starts_with("calls F_z of joint A on ground unique, which a self-stress of the joints"))
      << fault->because;
}

TEST_F(RanksTest, ClosedStatesCalledOpenAreAJacobian) {
  for (AskedState& one : asked_) {
    one.by[1].answer = StatedConstraints::Answer::open;
    one.by[1].place = "joint 'A'";
  }
  expect(ConstraintOpinion(model_, asked_).refuses_closed(), Term::jacobian, "joint A");
  for (AskedState& one : asked_) one.by[0].answer = StatedConstraints::Answer::open;
  EXPECT_FALSE(ConstraintOpinion(model_, asked_).refuses_closed());
}

TEST_F(RanksTest, TotalsThatOnlyACouplingMovesAreFlagsToo) {
  add_ball();
  for (AskedState& one : asked_) {
    for (auto& by : one.by) by.rank->joints[0].unique_total[0][5] = true;  // a hinge carries no T_z, its coupling may
    one.by[1].rank->joints[0].unique_total[0][5] = false;
  }
  const auto fault = ConstraintOpinion(model_, asked_).wrong_uniqueness();
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->solver, 1);
  EXPECT_THAT(fault->because, testing::HasSubstr("T_z of the total of joint A on ground"));
}

}  // namespace
}  // namespace concord::compare
