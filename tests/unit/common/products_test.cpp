#include "common/products.h"

#include <gtest/gtest.h>

namespace concord {
namespace {

struct ProductsTest : ::testing::Test {
  const MatX A = (MatX(2, 3) << 1.0, -2.0, 3.0, 0.5, 4.0, -1.0).finished();
  const MatX B = (MatX(3, 2) << 2.0, 1.0, -1.0, 3.0, 0.0, 5.0).finished();
};

TEST_F(ProductsTest, MultiplyRowsByColumns) {
  EXPECT_EQ(product(A, B), (MatX(2, 2) << 4.0, 10.0, -3.0, 7.5).finished());
  EXPECT_EQ(transposed_product(B, A.transpose()), product(A, B).transpose());
}

TEST_F(ProductsTest, ReadBlocksWithoutTheirSurroundings) {
  MatX surrounded = MatX::Constant(5, 6, 1e300);
  surrounded.block(1, 2, 3, 2) = B;
  EXPECT_EQ(product(A, surrounded.block(1, 2, 3, 2)), product(A, B));
}

TEST_F(ProductsTest, CongruenceIsTheFormInOtherCoordinates) {
  const MatX form = (MatX(3, 3) << 2.0, 1.0, 0.0, -1.0, 3.0, 4.0, 5.0, 0.0, 1.0).finished();  // not symmetric
  const VecX x = (VecX(2) << 0.5, -2.0).finished();
  const VecX y = (VecX(2) << 3.0, 1.0).finished();
  EXPECT_DOUBLE_EQ(x.dot(congruence(B, form) * y), (B * x).dot(form * (B * y)));
  EXPECT_EQ(diagonal_of_congruence(B, form), congruence(B, form).diagonal());
}

TEST_F(ProductsTest, OutsideASpanNothingOfItIsLeft) {
  const MatX Q = (MatX(3, 1) << 0.6, 0.0, 0.8).finished();
  const MatX left = outside_span(Q, B);
  EXPECT_LE((Q.transpose() * left).norm(), 1e-15);
  EXPECT_LE((left + Q * (Q.transpose() * B) - B).norm(), 1e-15);
  EXPECT_EQ(outside_span(MatX(3, 0), B), B);
}

TEST_F(ProductsTest, OfNothingIsZero) {
  EXPECT_EQ(product(MatX(2, 0), MatX(0, 3)), MatX::Zero(2, 3));
  EXPECT_EQ(congruence(MatX(3, 0), MatX::Identity(3, 3)).size(), 0);
}

}  // namespace
}  // namespace concord
