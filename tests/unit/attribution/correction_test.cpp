#include "compare/attribution/correction.h"

#include <gtest/gtest.h>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// Two pendulum solvers, of which the second one solves another model than is stated.
class CorrectionTest : public ::testing::Test {
 protected:
  /// A solver that has the fault in every model that it is given.
  struct WrongSolver : FakePendulum {
    WrongSolver(std::unique_ptr<Model> model) : FakePendulum(*model, "wrong"), own(std::move(model)) {}
    std::unique_ptr<Model> own;
  };

  std::unique_ptr<Solver> make_wrong(const Model& model) const {
    auto wrong = std::make_unique<Model>(model);
    change_(*wrong);
    return std::make_unique<WrongSolver>(std::move(wrong));
  }

  Evidence evidence() {
    FakePendulum right(model_, "right");
    const auto wrong = make_wrong(model_);
    RunOptions run;
    run.until = 2.0;
    run.samples = 60;
    trajectory_ = right.integrate(run, {});
    evaluations_.clear();
    std::array<Auditor, 2> auditors{Auditor(model_), Auditor(model_)};
    for (const Sample& sample : trajectory_.samples) {
      evaluations_.push_back({right.evaluate(sample.state), wrong->evaluate(sample.state)});
      for (int who = 0; who < 2; ++who) auditors[who].add(sample.state, evaluations_.back()[who]);
    }
    Evidence evidence{model_, {auditors[0].report(), auditors[1].report()}, {}, {}};
    for (std::size_t k = 0; k < evaluations_.size(); ++k) {
      evidence.states.push_back({&trajectory_.samples[k].state, {&evaluations_[k][0], &evaluations_[k][1]}});
    }
    return evidence;
  }

  std::optional<Trial> attempt(const Attribution& blame) {
    return try_correction(evidence(), blame, [this](const Model& model) { return make_wrong(model); });
  }

  Model model_ = sprung_pendulum_model();
  std::function<void(Model&)> change_ = [](Model& model) { model.bodies[1].inertia_L *= 1.3; };
  Trajectory trajectory_;
  std::vector<std::array<Evaluation, 2>> evaluations_;
};

TEST_F(CorrectionTest, AWrongInertiaClosesWithLoadsOnItsBody) {
  const auto trial = attempt({1, Term::inertia, "body bob", ""});
  ASSERT_TRUE(trial);
  EXPECT_GT(trial->digits, 8.0);
  EXPECT_EQ(trial->where, "body bob");
  EXPECT_TRUE(describe(*trial).starts_with("; confirmed: put right by loads on body bob, the difference closes by"));
}

TEST_F(CorrectionTest, AWrongElementClosesWithTheOthersWrench) {
  change_ = [](Model& model) { std::get<LineSpring>(model.elements[0].what).law.stiffness *= 1.5; };
  const auto trial = attempt({1, Term::applied, "force element strut", ""});
  ASSERT_TRUE(trial);
  EXPECT_GT(trial->digits, 8.0);
}

TEST_F(CorrectionTest, AWrongGuessDoesNotClose) {
  change_ = [](Model& model) {
    std::get<LineSpring>(model.elements[0].what).law.stiffness *= 1.5;
    model.bodies[1].inertia_L *= 1.3;
  };
  const auto trial = attempt({1, Term::applied, "force element strut", ""});
  ASSERT_TRUE(trial);
  EXPECT_FALSE(trial->confirms());
  EXPECT_NE(describe(*trial).find("not confirmed"), std::string::npos);
  // The body is out of balance by its inertia alone: what the strut does wrong stays.
}

TEST_F(CorrectionTest, WhatNoLoadChangesIsNotTried) {
  EXPECT_FALSE(attempt({1, Term::jacobian, "joint A", ""}));
  EXPECT_FALSE(attempt({1, Term::frame, "joint A", ""}));
  EXPECT_FALSE(attempt({2, Term::inertia, "body bob", ""}));
}

TEST_F(CorrectionTest, AConfirmedGuessSaysSo) {
  const SolverMaker maker = [this](const Model& model) { return make_wrong(model); };
  const auto cause = find_confirmed_cause(evidence(), {maker, maker});
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->where, "body bob");
  ASSERT_TRUE(cause->closed_digits);
  EXPECT_GT(*cause->closed_digits, 8.0);
  EXPECT_NE(cause->because.find("; confirmed"), std::string::npos);
}

}  // namespace
}  // namespace concord::compare
