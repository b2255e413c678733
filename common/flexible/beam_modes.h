#pragma once

#include <vector>

#include "common/flexible/beam.h"
#include "common/flexible/beam_line.h"

/// The modes of a beam, family by family.
namespace concord::beams {

/// Modes of one family after orthogonalization: numbers at all nodes, one column each, and frequencies [rad/s].
struct FamilyModes {
  Line line;
  MatX shapes;
  VecX frequencies;
  std::vector<int> columns;  // which modes of the beam they are
};

/// The modes of a family that the beam asks for; without columns if it asks for none. Throws std::invalid_argument if
/// one does not exist or is asked for twice.
FamilyModes make_family(const BeamSpecification& beam, BeamFamily family);

}  // namespace concord::beams
