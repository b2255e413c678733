#include "compare/audit/open_directions.h"

#include <algorithm>
#include <limits>

#include "common/decompositions.h"
#include "common/products.h"

namespace concord::compare {

namespace {

/// The number of `sizes` (largest first) above a threshold.
int count_above(const VecX& sizes, double threshold) { return static_cast<int>((sizes.array() > threshold).count()); }

}  // namespace

Mat3 OpenDirections::projector() const { return outside_span(directions, Mat3::Identity()); }

OpenDirections open_directions(const MachineConstraints& constraints, int joint, Side side, int part) {
  constexpr double kIndependent = 1e-6;
  constexpr double kOtherThreshold = 30.0;
  constexpr double kSmallDoubt = 1e-10;
  constexpr double kClearlyMoved = 1e-4;
  OpenDirections open;
  open.directions.resize(3, 0);
  const MatX carried = constraints.reactions_on(joint, side).middleRows<3>(3 * part);
  if (carried.cols() == 0) return open;
  const VecX sizes = singular_values(carried);
  open.carried = count_above(sizes, kIndependent * std::max(sizes.maxCoeff(), kIndependent));
  if (constraints.self_stresses().cols() == 0) return open;
  const Svd moved = svd_of(product(carried, constraints.self_stresses()));
  const double least = constraints.unmoved();
  const int n = count_above(moved.sigma, least);
  open.directions = moved.U.leftCols(n);
  open.is_clear =
      n == count_above(moved.sigma, least * kOtherThreshold) && n == count_above(moved.sigma, least / kOtherThreshold);
  if (n == 0) return open;
  const double round_off = 4.0 * std::numeric_limits<double>::epsilon() * constraints.largest_moved();
  const double left = n < moved.sigma.size() ? moved.sigma(n) : 0.0;
  const double smallest_kept = std::min(constraints.report().smallest_kept, 1.0);
  open.doubt = std::max(left, round_off / smallest_kept) / moved.sigma(n - 1);
  open.is_clear =
      open.is_clear && open.doubt < kSmallDoubt && moved.sigma(n - 1) > kClearlyMoved * constraints.largest_moved();
  return open;
}

}  // namespace concord::compare
