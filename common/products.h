#pragma once

#include "common/types.h"

/// Products of dense matrices of any size, compiled once. Eigen compiles its operator* anew for each pair of types, in
/// a third of a second, and more for each product within a product. They allocate their result: not for hot paths, nor
/// for products with a vector or of fixed sizes, which compile fast.
namespace concord {

/// What is read of a matrix of any shape, or of a block of one, without a copy.
using MatrixView = Eigen::Ref<const MatX>;

/// A B
MatX product(const MatrixView& A, const MatrixView& B);
/// A^T B
MatX transposed_product(const MatrixView& A, const MatrixView& B);
/// T^T A T: a quadratic form A in the coordinates whose directions are the columns of T.
MatX congruence(const MatrixView& T, const MatrixView& A);
/// Its diagonal alone: the form of each column.
VecX diagonal_of_congruence(const MatrixView& T, const MatrixView& A);
/// A - Q Q^T A: what columns have outside the span of the orthonormal columns of Q.
MatX outside_span(const MatrixView& Q, const MatrixView& A);

}  // namespace concord
