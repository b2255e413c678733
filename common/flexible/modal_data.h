#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/types.h"

namespace concord {

struct BeamSpecification;

/// A mass point of a flexible body: mass [kg], undeformed position in the body frame [m], translation rows of the m
/// mode shapes there (3 x m): its deformed position is s0_L + Psi_t_L a.
struct MassPoint {
  double mass = 0.0;
  Vec3 s0_L = Vec3::Zero();
  Mat3X Psi_t_L;
};

/// A named place on a flexible body where joints can attach: undeformed position, translation and rotation rows of the
/// mode shapes (3 x m each), all in body axes.
struct ModalNode {
  std::string name;
  Vec3 s0_L = Vec3::Zero();
  Mat3X Psi_t_L;
  Mat3X Psi_r_L;
};

/// A flexible body in modal coordinates (S3): either the mass points or their integrals.
struct ModalData {
  /// All entries of G = sum of m w w^T over the mass points, w = [1; s_0; psi_1; ...; psi_m]: (4 + 3 m) square.
  MatX G;
  /// Modal stiffness and damping, m x m, symmetric.
  MatX stiffness;
  MatX damping;
  std::vector<ModalNode> nodes;
  /// The referee's view of G: the mass points themselves, or at most 4 + 3 m equivalent points if G was given outright.
  std::vector<MassPoint> mass_points;
  /// Undamped frequencies of the modes [rad/s] as their source gives them, for `info`; may be empty.
  VecX frequencies;
  /// The beam that they are the modes of, for the audit; none for modes of another source, or told otherwise.
  std::shared_ptr<const BeamSpecification> beam;

  [[nodiscard]] int n_modes() const { return static_cast<int>(stiffness.rows()); }
};

/// How far a unit of each modal coordinate moves a mass point at most [m].
VecX largest_displacements(const ModalData& modal);

/// G of a set of mass points with m modes each (S3).
MatX mass_integrals(const std::vector<MassPoint>& points, int n_modes);

/// G with rows and columns divided by the roots of the diagonal, where that is positive: entries without units.
MatX without_units(const MatX& G);

/// At most 4 + 3 m mass points whose integrals are G (positive semidefinite, G(0, 0) > 0) (S5).
std::vector<MassPoint> equivalent_mass_points(const MatX& G);

}  // namespace concord
