#include "compare/audit/beam_statement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "common/flexible/beam.h"
#include "common/products.h"
#include "compare/audit/beam_shapes.h"

namespace concord::compare {

namespace {

/// What sums over a beam leave of themselves as round-off.
constexpr double kRoundOffOfBeam = 256.0 * std::numeric_limits<double>::epsilon();

/// Gauss-Legendre points on [0, 1] and weights, exact for cubics times cubics.
constexpr std::array<std::array<double, 2>, 4> kBeamPoints{{{0.06943184420297371, 0.17392742256872693},
                                                            {0.33000947820757187, 0.32607257743127307},
                                                            {0.66999052179242813, 0.32607257743127307},
                                                            {0.93056815579702629, 0.17392742256872693}}};

/// The motion of a node in the axes of the beam: columns of displacements and rotations, one for each mode.
struct NodeMotion {
  Mat3X displacement;
  Mat3X rotation;
};

/// Numbers of a section for unit modal coordinates, m columns: values and how large the terms of their sums are.
struct BeamStrains {
  MatX values;  // stretch, twist, curvature in x-y, curvature in x-z
  MatX sizes;
};

/// Displacement of the axis (rows x, y, z) and twist, 4 x m.
using SectionMotion = Eigen::Matrix<double, 4, Eigen::Dynamic>;

/// One element between two nodes. A slope of y is a rotation about z, a slope of z one about -y: cubics through
/// displacements and slopes, straight lines through stretch and twist.
class BeamElement {
 public:
  BeamElement(const NodeMotion& left, const NodeMotion& right, double width)
      : left_(left), right_(right), width_(width) {}

  [[nodiscard]] SectionMotion at(double s) const {
    const double s2 = s * s;
    const double s3 = s2 * s;
    const std::array<double, 4> cubic{1 - 3 * s2 + 2 * s3, width_ * (s - 2 * s2 + s3), 3 * s2 - 2 * s3,
                                      width_ * (s3 - s2)};
    SectionMotion motion(4, left_.displacement.cols());
    motion.row(0) = (1 - s) * left_.displacement.row(0) + s * right_.displacement.row(0);
    motion.row(1) = cubic[0] * left_.displacement.row(1) + cubic[1] * left_.rotation.row(2) +
                    cubic[2] * right_.displacement.row(1) + cubic[3] * right_.rotation.row(2);
    motion.row(2) = cubic[0] * left_.displacement.row(2) - cubic[1] * left_.rotation.row(1) +
                    cubic[2] * right_.displacement.row(2) - cubic[3] * right_.rotation.row(1);
    motion.row(3) = (1 - s) * left_.rotation.row(0) + s * right_.rotation.row(0);
    return motion;
  }

  [[nodiscard]] BeamStrains strains(double s) const {
    BeamStrains found{MatX::Zero(4, left_.displacement.cols()), MatX::Zero(4, left_.displacement.cols())};
    const auto add = [&found](int row, double factor, const auto& numbers) {
      found.values.row(row) += factor * numbers;
      found.sizes.row(row) += std::abs(factor) * numbers.cwiseAbs();
    };
    add(0, -1.0 / width_, left_.displacement.row(0));
    add(0, 1.0 / width_, right_.displacement.row(0));
    add(1, -1.0 / width_, left_.rotation.row(0));
    add(1, 1.0 / width_, right_.rotation.row(0));
    const double bend = (12 * s - 6) / (width_ * width_);
    for (const auto& [row, component, slope, sign] : {std::tuple(2, 1, 2, 1.0), std::tuple(3, 2, 1, -1.0)}) {
      add(row, bend, left_.displacement.row(component));
      add(row, -bend, right_.displacement.row(component));
      add(row, sign * (6 * s - 4) / width_, left_.rotation.row(slope));
      add(row, sign * (6 * s - 2) / width_, right_.rotation.row(slope));
    }
    return found;
  }

 private:
  const NodeMotion& left_;
  const NodeMotion& right_;
  double width_;
};

/// w = [1; s_0; psi_1; ...] of the axis at x, and its slopes over y and z of the section: a section keeps its shape and
/// turns with its twist alone.
std::array<VecX, 3> places_of_section(const BeamSpecification& beam, double x, const SectionMotion& motion) {
  const Eigen::Index m = motion.cols();
  std::array<VecX, 3> w{VecX::Zero(4 + 3 * m), VecX::Zero(4 + 3 * m), VecX::Zero(4 + 3 * m)};
  w[0](0) = 1.0;
  w[0].segment<3>(1) = beam.first_end_L + x * beam.axes.col(0);
  w[1].segment<3>(1) = beam.axes.col(1);
  w[2].segment<3>(1) = beam.axes.col(2);
  for (Eigen::Index k = 0; k < m; ++k) {
    w[0].segment<3>(4 + 3 * k) = beam.axes * motion.col(k).head<3>();
    w[1].segment<3>(4 + 3 * k) = motion(3, k) * beam.axes.col(2);
    w[2].segment<3>(4 + 3 * k) = -motion(3, k) * beam.axes.col(1);
  }
  return w;
}

/// BeamIntegrals over the whole beam, with how large the round-off of the stiffness may be.
struct BeamIntegrals {
  MatX G;
  MatX stiffness;
  MatX doubt;
};

BeamIntegrals integrate_beam(const BeamSpecification& beam, const std::vector<NodeMotion>& nodes) {
  const Eigen::Index m = nodes.front().displacement.cols();
  BeamIntegrals sums{MatX::Zero(4 + 3 * m, 4 + 3 * m), MatX::Zero(m, m), MatX::Zero(m, m)};
  const double width = beam.length / beam.elements;
  const Eigen::Vector4d rigidity(beam.youngs_modulus * beam.area, beam.shear_modulus * beam.torsion_constant,
                                 beam.youngs_modulus * beam.second_moment_z,
                                 beam.youngs_modulus * beam.second_moment_y);
  MatX W(4 + 3 * m, 3 * static_cast<Eigen::Index>(kBeamPoints.size()));
  const std::array<double, 3> of_section{beam.area, beam.second_moment_z, beam.second_moment_y};
  for (int e = 0; e < beam.elements; ++e) {
    const BeamElement element(nodes[e], nodes[e + 1], width);
    Eigen::Index column = 0;
    for (const auto& [s, weight] : kBeamPoints) {
      const BeamStrains strains = element.strains(s);
      const MatX pulled = (weight * width * rigidity).asDiagonal() * strains.values;
      sums.stiffness += transposed_product(strains.values, pulled);
      const MatX doubted = transposed_product(strains.sizes, pulled.cwiseAbs());
      sums.doubt += kRoundOffOfBeam * (doubted + doubted.transpose());
      const std::array<VecX, 3> w = places_of_section(beam, width * (e + s), element.at(s));
      for (std::size_t k = 0; k < 3; ++k) {
        W.col(column++) = std::sqrt(weight * width * beam.density * of_section[k]) * w[k];
      }
    }
    sums.G.selfadjointView<Eigen::Lower>().rankUpdate(W);
  }
  sums.G = MatX(sums.G.selfadjointView<Eigen::Lower>());
  return sums;
}

/// The largest part of a difference that round-off does not explain.
template <class Difference, class Doubt, class Size>
double largest_beyond(const Difference& difference, const Doubt& doubt, const Size& size) {
  double largest = 0.0;
  for (Eigen::Index k = 0; k < difference.rows(); ++k) {
    for (Eigen::Index l = 0; l < difference.cols(); ++l) {
      const double beyond = (std::abs(difference(k, l)) - doubt(k, l)) / size(k, l);
      if (!(beyond <= largest)) largest = std::isnan(beyond) ? std::numeric_limits<double>::infinity() : beyond;
    }
  }
  return largest;
}

}  // namespace

VecX block_sizes_of(const MatX& G) {
  VecX sizes(G.rows());
  sizes(0) = std::sqrt(G(0, 0));
  for (Eigen::Index first = 1; first < G.rows(); first += 3) {
    sizes.segment<3>(first).setConstant(std::sqrt(G.diagonal().segment<3>(first).sum()));
  }
  return sizes;
}

BeamMisfit compute_misfit_of_beam(const ModalData& modal) {
  const BeamSpecification& beam = *modal.beam;
  BeamMisfit misfit;
  std::vector<NodeMotion> nodes;
  for (int k = 0; k <= beam.elements; ++k) {
    const ModalNode& node = modal.nodes[static_cast<std::size_t>(k)];
    const Vec3 place = beam.first_end_L + beam.length * k / beam.elements * beam.axes.col(0);
    const double size = beam.length + beam.first_end_L.norm();
    misfit.nodes = std::max(misfit.nodes, (node.s0_L - place).norm() / size - kRoundOffOfBeam);
    nodes.push_back({beam.axes.transpose() * node.Psi_t_L, beam.axes.transpose() * node.Psi_r_L});
  }
  const BeamIntegrals own = integrate_beam(beam, nodes);
  const VecX masses = block_sizes_of(own.G);
  const MatX of_masses = masses * masses.transpose();
  misfit.mass = largest_beyond(modal.G - own.G, kRoundOffOfBeam * of_masses, of_masses);
  const VecX roots = own.stiffness.diagonal().cwiseSqrt();
  const MatX of_stiffness = roots * roots.transpose();
  misfit.stiffness =
      largest_beyond(modal.stiffness - own.stiffness, own.doubt + kRoundOffOfBeam * of_stiffness, of_stiffness);
  // Of the modal mass one: damping is 2 zeta omega of each mode.
  const VecX frequencies = modal.stiffness.diagonal().cwiseSqrt();
  const MatX damping = (2.0 * beam.damping_ratio * frequencies).asDiagonal();
  const VecX of_damping = (beam.damping_ratio > 0.0 ? 2.0 * beam.damping_ratio : 1.0) * frequencies;
  const MatX of_pairs = of_damping.cwiseSqrt() * of_damping.cwiseSqrt().transpose();
  misfit.damping = largest_beyond(modal.damping - damping, kRoundOffOfBeam * of_pairs, of_pairs);
  return misfit;
}

AuditEntity audit_beam(const Body& body) {
  AuditEntity entity{body.name, {}, false};
  if (!body.modal || !body.modal->beam) return entity;
  const std::array<double, 4> misfit = compute_misfit_of_beam(*body.modal).all();
  for (std::size_t row = 0; row < misfit.size(); ++row) {
    entity.rows.push_back({AuditRule::modal_data, kBeamRows[row], AuditUnit::own});
    entity.rows.back().take(misfit[row], 1.0, 0.0);
  }
  if (body.modal->beam->elements > kMostElementsOfShapes) return entity;
  // Eigenvectors of high modes, and of many elements, are known to so many digits; a wrong shape has few right.
  constexpr double kKnown = 1e-7;
  const ShapeMisfit shapes = compute_misfit_of_shapes(*body.modal);
  for (const auto& [name, beyond] :
       {std::pair{"shapes of modes", shapes.shape}, std::pair{"modal masses", shapes.mass}}) {
    entity.rows.push_back({AuditRule::modal_data, name, AuditUnit::own});
    entity.rows.back().take(beyond > kKnown ? beyond : 0.0, 1.0, 0.0);
  }
  return entity;
}

}  // namespace concord::compare
