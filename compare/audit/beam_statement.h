#pragma once

#include <array>

#include "common/model.h"
#include "compare/audit/audit_ledger.h"

/// Are the modes of a beam those of the beam that the model states? Stiffness, damping and mass integrals are
/// integrated anew over the stated section and material, from the motion of the nodes alone, by code of the audit's
/// own.
namespace concord::compare {

/// What of the modal data the statement does not explain, beyond round-off, relative to its size.
struct BeamMisfit {
  double nodes = 0.0;      // places, in parts of the length
  double mass = 0.0;       // all entries of G
  double stiffness = 0.0;  // of every pair of modes, in parts of the root of their own
  double damping = 0.0;

  [[nodiscard]] std::array<double, 4> all() const { return {nodes, mass, stiffness, damping}; }
};

/// In the order of BeamMisfit: "places of nodes", "mass integrals", ...
inline constexpr std::array kBeamRows{"places of nodes", "mass integrals", "modal stiffness", "modal damping"};

/// What entries of mass integrals G are held against, rows times columns: roots of what belongs to the mass, to the
/// places and to each mode.
VecX block_sizes_of(const MatX& G);

/// Of modal data that were made from a beam: `modal.beam` must be set.
BeamMisfit compute_misfit_of_beam(const ModalData& modal);

/// The rows of a body, which do not change with the state; none if it was not made from a beam.
AuditEntity audit_beam(const Body& body);

}  // namespace concord::compare
