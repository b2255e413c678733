#pragma once

#include "common/flexible/modal_data.h"

/// Are the modes of a beam the shapes that its statement names? The audit forms finite elements of its own, from the
/// textbook's matrices, and solves their eigenproblem.
namespace concord::compare {

/// Beams of more elements are not asked: the eigenproblem is solved with full matrices.
inline constexpr int kMostElementsOfShapes = 200;

struct ShapeMisfit {
  /// The part of a mode, of modal mass 1, that is no sum of the stated modes of its family, beyond what eigensolvers
  /// know of them.
  double shape = 0.0;
  double mass = 0.0;  // of the modal masses from 1, and of pairs of modes from 0
};

/// Of modal data that were made from a beam of at most so many elements: `modal.beam` must be set.
ShapeMisfit compute_misfit_of_shapes(const ModalData& modal);

}  // namespace concord::compare
