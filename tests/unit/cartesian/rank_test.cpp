#include "cartesian/rank.h"

#include <gtest/gtest.h>

#include <memory>

#include "common/joints/catalogue.h"
#include "common/joints/distance.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

SparseMatrix sparse(const MatX& matrix) { return matrix.sparseView().cast<double>(); }

/// Rows of unit norm of which the last is a combination of two others.
MatX dependent_rows(int rows, int columns) {
  testing::Numbers numbers(71);
  MatX matrix = numbers.matrix(rows, columns);
  matrix.row(rows - 1) = matrix.row(0) - 2.0 * matrix.row(1);
  return matrix.rowwise().normalized();
}

void expect_one_dependent(const MatX& matrix) {
  const RankDecision decision = decide_rank(sparse(matrix));
  EXPECT_EQ(decision.rank, matrix.rows() - 1);
  ASSERT_EQ(decision.left_null_space.cols(), 1);
  EXPECT_LT((decision.left_null_space.transpose() * matrix).norm(), 1e-12);
  EXPECT_NEAR(decision.left_null_space.norm(), 1.0, 1e-12);
  EXPECT_EQ(std::count(decision.independent.begin(), decision.independent.end(), false), 1);
}

TEST(Rank, FindsADependentRowBySingularValues) { expect_one_dependent(dependent_rows(7, 12)); }

TEST(Rank, FindsADependentRowBySparseQr) { expect_one_dependent(dependent_rows(520, 560)); }

/// Two rows that differ by a part of 1e-7, 3e-10 or 1e-14: kept, in doubt, dropped.
TEST(Rank, SmallSingularValuesAreFoundExactly) {
  testing::Numbers numbers(72);
  for (const int rows : {9, 80}) {
    for (const double apart : {1e-7, 3e-10, 1e-14}) {
      SCOPED_TRACE(apart);
      MatX matrix = numbers.matrix(rows, 2 * rows).rowwise().normalized();
      VecX off = numbers.matrix(2 * rows, 1);
      off -= matrix.transpose() * (matrix * matrix.transpose()).ldlt().solve(matrix * off);
      matrix.row(rows - 1) = (matrix.row(2) + apart * off.normalized().transpose()).normalized();
      const RankDecision decision = decide_rank(sparse(matrix));
      const VecX values = matrix.jacobiSvd().singularValues();
      const double smallest = values(rows - 1) / values(0);
      EXPECT_EQ(decision.rank, smallest > 1e-10 ? rows : rows - 1);
      EXPECT_EQ(decision.left_null_space.cols(), rows - decision.rank);
      if (apart > 1e-12) {
        ASSERT_EQ(decision.near_values.size(), 1);
        EXPECT_NEAR(decision.near_values(0), smallest, 0.2 * smallest);
        EXPECT_LT((decision.near_null_space.transpose() * matrix).norm(), 1.1 * smallest * values(0));
      }
    }
  }
}

TEST(Rank, RowsThatGoFirstStayWhereRowsDependOnEachOther) {
  for (const int rows : {7, 90}) {
    const MatX matrix = dependent_rows(rows, rows + 40);  // the first, the second and the last depend on each other
    for (const int last : {0, 1, rows - 1}) {
      std::vector<bool> goes_first(rows, true);
      goes_first[last] = false;
      const RankDecision decision = decide_rank(sparse(matrix), &goes_first);
      EXPECT_EQ(decision.rank, rows - 1);
      EXPECT_FALSE(decision.independent[last]);
    }
  }
}

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

TEST(Rank, FlagsThatAnotherThresholdWouldChangeAreUndecided) {
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

TEST(Rank, ShortestSolutionLeavesDependentRowsOut) {
  const MatX matrix = dependent_rows(5, 9);
  const VecX known = matrix.transpose() * VecX::LinSpaced(5, -1.0, 2.0);  // in the row space: already the shortest
  const VecX x = solve_shortest(sparse(matrix), matrix * known);
  EXPECT_LT((matrix * (x - known)).norm(), 1e-13);
}

}  // namespace
}  // namespace concord::cartesian
