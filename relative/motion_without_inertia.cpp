#include "relative/motion_without_inertia.h"

#include <cmath>

#include "common/decompositions.h"
#include "relative/joint_factors.h"

namespace concord::relative {

/// The least eigenvalue of H^T I H, its columns scaled by the terms that their inertia is made of.
std::optional<MotionWithoutInertia> find_motion_without_inertia(const ArticulatedInertias& tree) {
  constexpr double kLeast = 4.0 * kRoundOffOfPivot;  // a pivot at round-off must be found here
  for (const LinkIndex l : downward<LinkIndex>(tree.n_links())) {
    const ArticulatedBody& link = tree.link(l);
    if (link.n_free == 0) continue;
    const Eigen::Map<const Mat6X> H(tree.free_columns(l).data(), 6, link.n_free);
    const MatX terms = H.cwiseAbs().transpose() * link.articulated_inertia.cwiseAbs() * H.cwiseAbs();
    const VecX units = terms.diagonal().unaryExpr([](double size) { return size > 0.0 ? 1.0 / std::sqrt(size) : 1.0; });
    const MatX scaled = units.asDiagonal() * H.transpose() * link.articulated_inertia * H * units.asDiagonal();
    const SymmetricEigenpairs spectrum = symmetric_eigenpairs(scaled);
    if (spectrum.values(0) > kLeast) continue;
    MotionWithoutInertia found{l, JointVector::Zero(link.n_free + link.n_driven)};
    for (int k = 0; k < link.n_free; ++k) found.u(link.free_column[k]) = units(k) * spectrum.vectors(k, 0);
    return found;
  }
  return std::nullopt;
}

}  // namespace concord::relative
