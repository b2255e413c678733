#pragma once

#include <optional>

#include "relative/rank/closing.h"

namespace concord::relative {

/// Closes a machine whose guesses `from` Newton's method could not close: from a dozen reproducible starts round about,
/// in which turns that the model says nothing of lie anywhere, slides within a length, and guesses a tenth of that.
/// Guesses at which the misfit is stationary, as a linkage that is stretched, end there. Of the poses that close the
/// one nearest to the guesses, other coordinates counting little; nothing if there is none. Angles end within half a
/// turn of their guess, or of zero. Prescribed coordinates stay.
[[nodiscard]] std::optional<Coordinates> search_closed_start(const ScaledClosure& scaled, const Coordinates& from,
                                                             const PrescribedMask& prescribed);

}  // namespace concord::relative
