#include "cartesian/dynamics/sparse_lu.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace concord::cartesian {
namespace {

/// [2 0 1; 0 3 0; 1 0 0] with a structural zero at (2, 2).
SparseLu make_matrix() { return {{0, 2, 3, 5}, {0, 2, 1, 0, 2}}; }

void fill(SparseLu& matrix, double corner) {
  matrix.values()[matrix.find(0, 0)] = 2.0;
  matrix.values()[matrix.find(2, 0)] = 1.0;
  matrix.values()[matrix.find(1, 1)] = 3.0;
  matrix.values()[matrix.find(0, 2)] = 1.0;
  matrix.values()[matrix.find(2, 2)] = corner;
}

TEST(SparseLu, SolvesAndRefactorsWithAFrozenPattern) {
  SparseLu matrix = make_matrix();
  fill(matrix, 0.0);
  ASSERT_TRUE(matrix.factor());
  VecX x = Vec3(4.0, 6.0, 1.0);
  ASSERT_TRUE(matrix.solve_refined(x, 1e-15));
  EXPECT_LT((x - Vec3(1.0, 2.0, 2.0)).norm(), 1e-15);
  fill(matrix, 5.0);
  ASSERT_TRUE(matrix.refactor());
  x = Vec3(3.0, 3.0, 6.0);
  ASSERT_TRUE(matrix.solve_refined(x, 1e-15));
  EXPECT_LT((x - Vec3(1.0, 1.0, 1.0)).norm(), 1e-15);
}

TEST(SparseLu, TellsASingularMatrix) {
  SparseLu matrix = make_matrix();
  fill(matrix, 0.5);  // third row is half the first
  EXPECT_FALSE(matrix.factor());
}

constexpr int kSize = 8;

SparseLu make_full() {
  std::vector<int> starts{0};
  std::vector<int> rows;
  for (int c = 0; c < kSize; ++c) {
    for (int r = 0; r < kSize; ++r) rows.push_back(r);
    starts.push_back(static_cast<int>(rows.size()));
  }
  return {starts, rows};
}

/// An 8 x 8 Hilbert matrix by its common denominator: integers, condition 1e10. `row` and `column` scale.
void fill_hilbert(SparseLu& matrix, double row, double column) {
  for (int c = 0; c < kSize; ++c) {
    for (int r = 0; r < kSize; ++r) {
      const double by_row = r % 2 == 0 ? row : 1.0;
      const double by_column = c % 3 == 0 ? column : 1.0;
      matrix.values()[matrix.find(r, c)] = 360360.0 / (r + c + 1) * by_row * by_column;
    }
  }
}

TEST(SparseLu, RefinesAnIllConditionedSystemToRoundOff) {
  SparseLu matrix = make_full();
  fill_hilbert(matrix, 1.0, 1.0);
  const VecX known = VecX::Ones(kSize);
  VecX x = VecX::Zero(kSize);
  matrix.subtract_product(-known, x);
  ASSERT_TRUE(matrix.factor());
  VecX rough = x;
  matrix.solve(rough);
  EXPECT_GT((rough - known).norm(), 1e-10);
  ASSERT_TRUE(matrix.solve_refined(x, 0.0));
  EXPECT_LE((x - known).lpNorm<Eigen::Infinity>(), 1e-15);
  EXPECT_GT(matrix.relative_correction(), 1e-12);
  EXPECT_GT(matrix.first_correction().lpNorm<Eigen::Infinity>(), 1e-12);
}

/// Two equations with the pivot gone bad beside others with terms a thousand million times larger.
TEST(SparseLu, HoldsEachEquationByItsOwnTerms) {
  constexpr double kPart = 1e-12;
  SparseLu matrix = make_full();
  for (int k = 0; k < kSize; ++k) matrix.values()[matrix.find(k, k)] = 1.0;
  matrix.values()[matrix.find(1, 0)] = matrix.values()[matrix.find(0, 1)] = 1.0;
  matrix.values()[matrix.find(1, 1)] = -1.0;
  ASSERT_TRUE(matrix.factor());
  matrix.values()[matrix.find(0, 0)] = 1e-9;
  ASSERT_TRUE(matrix.refactor());
  VecX known = VecX::Constant(kSize, 1e9);
  known.head<2>() << 1.0 / 3.0, 0.7;
  VecX right_side = VecX::Zero(kSize);
  matrix.subtract_product(-known, right_side);
  VecX x = right_side;
  matrix.solve(x);
  ASSERT_GT((x - known).head<2>().norm(), 1e-10);
  x = right_side;
  ASSERT_TRUE(matrix.solve_equation_by_equation(x, kPart, VecX::Zero(kSize)));
  EXPECT_LT((x - known).head<2>().norm(), 1e-15);
  EXPECT_GT(matrix.relative_correction(), 0.0);
  x = right_side;
  ASSERT_TRUE(matrix.solve_equation_by_equation(x, kPart,
                                                VecX::Constant(kSize, 1e9)));  // next to which 1/3 and 0.7 are nothing
  EXPECT_EQ(matrix.relative_correction(), 0.0);
}

TEST(SparseLu, UnitsThatArePowersOfTwoLeaveTheDigits) {
  const double row = std::ldexp(1.0, 70);
  const double column = std::ldexp(1.0, -90);
  SparseLu plain = make_full();
  SparseLu scaled = make_full();
  fill_hilbert(plain, 1.0, 1.0);
  fill_hilbert(scaled, row, column);
  ASSERT_TRUE(plain.factor());
  ASSERT_TRUE(scaled.factor());
  VecX x = VecX::LinSpaced(kSize, 0.3, 2.9);
  VecX y = x;
  for (int r = 0; r < kSize; r += 2) y(r) *= row;
  plain.solve(x);
  scaled.solve(y);
  for (int c = 0; c < kSize; ++c) EXPECT_EQ(x(c), y(c) * (c % 3 == 0 ? column : 1.0)) << c;
}

TEST(SparseLu, IdleRowsAndColumnsAreThoseOfTheIdentity) {
  SparseLu matrix = make_matrix();
  fill(matrix, 0.5);
  matrix.set_idle({false, false, true});
  ASSERT_TRUE(matrix.factor());
  VecX x = Vec3(4.0, 6.0, 0.0);
  ASSERT_TRUE(matrix.solve_refined(x, 0.0));
  EXPECT_LT((x - Vec3(2.0, 2.0, 0.0)).norm(), 1e-15);
}

/// What is left of the forces on a balanced rotor may be too small for a number to have all its digits.
TEST(SparseLu, ARightSideOfSubnormalNumbersIsNoSingularMatrix) {
  constexpr double kLeast = std::numeric_limits<double>::denorm_min();
  SparseLu matrix = make_full();
  for (int c = 0; c < kSize; ++c) {
    for (int r = 0; r < kSize; ++r) matrix.values()[matrix.find(r, c)] = std::cos(1.0 + 3.0 * r + 5.0 * r * c);
  }
  ASSERT_TRUE(matrix.factor());
  for (int k = 1; k < 200; ++k) {
    VecX x(kSize);
    for (int row = 0; row < kSize; ++row) x(row) = kLeast * std::round(k * std::sin(1.0 * row + k));
    EXPECT_TRUE(matrix.solve_refined(x, 0.0)) << k;
    EXPECT_LT(x.norm(), 1e-300);
  }
}

TEST(SparseLu, RefusesAnEntryOutsideThePattern) {
  const SparseLu matrix = make_matrix();
  EXPECT_THROW((void)matrix.find(1, 0), std::logic_error);
}

}  // namespace
}  // namespace concord::cartesian
