#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/needs.h"
#include "compare/quantities/observe.h"

/// Samples that fall on the instant at which a law of force jumps, as where a wheel leaves the edge of a bump: needed
/// by these (tests/verification/events_at_samples_test).
namespace concord::compare {

/// Finds the samples of a series in which each solver stands on another side of a jump, by round-off, so that the
/// difference of their forces says nothing about them: just before the sample and just after it both give the same,
/// another on each side, and what each gives in the sample is what both give on one of the sides. `sample_of`: a
/// sample's state and accelerations, by one of the solvers; `need`: digits below which a difference matters. What the
/// jump leaves open is written into `resolution` (rows of the layout, columns of the samples). Returns the times [s],
/// none where so many samples differ that jumps do not explain it.
std::vector<double> widen_at_jumps(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers,
                                   const Series& series, const std::vector<Measured>& measured,
                                   const std::function<Sample(std::size_t)>& sample_of, double need, MatX& resolution);

/// A note on them, if there are any.
std::string note_on_jumps(const std::vector<double>& times, Check check);

}  // namespace concord::compare
