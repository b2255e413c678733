#pragma once

#include "common/solver.h"

namespace concord::compare::analyses {

/// A motion in one instant, its beams stretched as far as its own forces stretch them: the closed state nearby in which
/// modes along the axes of beams do not accelerate, all else as it was. A beam that starts undeformed carries no axial
/// force before its axial modes have given way, however fast it spins, and carries what its motion asks for from then
/// on: by this force it is stiffened against bending. The sample itself where no beam stretches, or where the solver
/// finds no such state.
Sample with_beams_stretched(const Model& model, Solver& solver, const Sample& sample);

}  // namespace concord::compare::analyses
