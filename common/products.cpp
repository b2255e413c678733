#include "common/products.h"

namespace concord {

MatX product(const MatrixView& A, const MatrixView& B) { return A * B; }

MatX transposed_product(const MatrixView& A, const MatrixView& B) { return A.transpose() * B; }

MatX congruence(const MatrixView& T, const MatrixView& A) { return transposed_product(T, product(A, T)); }

VecX diagonal_of_congruence(const MatrixView& T, const MatrixView& A) {
  return T.cwiseProduct(product(A, T)).colwise().sum();
}

MatX outside_span(const MatrixView& Q, const MatrixView& A) { return A - product(Q, transposed_product(Q, A)); }

}  // namespace concord
